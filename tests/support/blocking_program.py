"""A program with every role, which blocks in the place that its argument names, and its end."""

import os
import time
from pathlib import Path

from support.program import running

CLEAN_UP = ["arm shut down", "released", "returned"]
# Two seconds are promised; busy machines need more.
END_S = 5.0

BLOCKING_PROGRAM = """
import signal, socket, sys, threading, time
from rosbase import BaseHandlers, BaseManager, BaseNode, LifecycleNode, CallbackReturn
from rosbase import RestartPolicy, register_multiprocess_nodes
from rosbase.messages import Header

PLACE = sys.argv[1]


def block():
    print("blocking", flush=True)
    if PLACE.startswith("input"):
        input("name? ")
    elif PLACE.startswith("event"):
        threading.Event().wait()
    elif PLACE.startswith("join"):
        threading.Thread(target=time.sleep, args=(100,), daemon=True).start()
        threading.enumerate()[-1].join()
    elif PLACE.startswith("recv"):
        left, right = socket.socketpair()
        with left, right:
            left.recv(1)
    elif PLACE.startswith("loop"):
        while True:
            pass
    elif PLACE.startswith("stubborn"):
        for _ in range(2):
            try:
                time.sleep(100)
            except BaseException:
                print("caught", flush=True)
    elif PLACE.startswith("native"):
        # Some two seconds within one call that does not let other threads run.
        try:
            sum(range(100_000_000))
        finally:
            print("interruptible", time.monotonic(), flush=True)
        time.sleep(100)
    elif PLACE.startswith("spin"):
        while True:
            manager.backend.spin_once(0.1)
    else:
        time.sleep(100)


class Camera(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.create_subscription(Header, "image", self.keep, 1)
        self.create_publisher(Header, "image", 1).publish(Header())
        if PLACE == "constructor":
            block()

    def keep(self, message):
        if PLACE.endswith("callback"):
            block()

    def release_resources(self):
        print("camera released", flush=True)


class Arm(LifecycleNode):
    autostart = "activate"

    def on_configure(self, state):
        if PLACE == "on_configure":
            block()
        return CallbackReturn.SUCCESS

    def on_deactivate(self, state):
        if PLACE == "on_deactivate":
            time.sleep(1.5)
        return CallbackReturn.SUCCESS

    def on_shutdown(self, state):
        print("arm shut down", flush=True)
        return CallbackReturn.SUCCESS


class Handlers(BaseHandlers):
    def handle(self):
        if PLACE.endswith("handle"):
            block()
        if self.timestamp == 0:
            print("running", flush=True)
            if PLACE == "thread":
                threading.Thread(target=time.sleep, args=(100,), name="logger of the arm").start()


class App(BaseManager):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        if PLACE == "own constructor":
            block()

    def handshake(self):
        if PLACE.endswith("handshake"):
            block()
        return super().handshake()

    def release_resources(self):
        if PLACE == "release":
            block()
        print("released", flush=True)


print("building", flush=True)
if "with a child" in sys.argv:
    always = RestartPolicy("always", first_delay_s=0.01)
    commands = {"child": "echo begun; exec sleep 500"}
    processes = register_multiprocess_nodes({}, commands, restart=always)
manager = App(nodes_dict={"camera": Camera, "arm": Arm}, handlers_class=Handlers)
manager.start_main_loop_timer(globals().get("processes"))
print("returned", flush=True)
if PLACE == "thread":
    import os
    os._exit(0)
if PLACE == "after":
    # From the program itself, for a machine may stall between two processes.
    signal.raise_signal(signal.SIGTERM)
    print("still there", flush=True)
    time.sleep(100)
"""


def expect_a_clean_end(folder: Path, source: str, place: str, signum: int) -> None:
    """Expect that a signal ends code that blocks there, with the whole clean-up."""
    with running(folder, source, place) as program:
        program.read_until("blocking")
        took_s, status, out, err = program.stop(signum)
        ended = time.monotonic()
    assert (status, err.count("Traceback")) == (0, 0), err
    lines = out.splitlines()
    assert lines[-3:] == CLEAN_UP
    if place.startswith("native"):
        # Code that cannot be interrupted takes its time.
        since = next(line for line in lines if line.startswith("interruptible"))
        took_s = ended - float(since.split()[1])
    assert took_s < END_S


def expect_the_end_of_an_input(folder: Path, source: str, signum: int) -> None:
    """Expect that a signal ends an `input()` on a terminal, with the whole clean-up."""
    main, terminal = os.openpty()
    try:
        with running(folder, source, "input in handle", stdin=terminal) as program:
            program.read_until("blocking")
            took_s, status, out, err = program.stop(signum)
    finally:
        os.close(main)
        os.close(terminal)
    assert (status, err.count("Traceback")) == (0, 0), err
    assert out.replace("name? ", "").splitlines()[-3:] == CLEAN_UP
    assert took_s < END_S


def expect_a_named_thread(folder: Path, source: str, signum: int) -> None:
    """Expect that a thread that never ends is named, and does not hold up the manager."""
    with running(folder, source, "thread") as program:
        program.read_until("running")
        took_s, status, out, err = program.stop(signum)
    assert (status, out.splitlines()[-3:]) == (0, CLEAN_UP), err
    assert "thread 'logger of the arm' still runs" in err
    assert took_s < END_S
