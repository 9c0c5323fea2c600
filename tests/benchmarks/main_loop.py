"""The manager's loop and topics beside the same by hand, in one run.

`nox -s bench` runs it and prints two tables. The ratios are what matters: machines are noisy,
so the rows take turns, and the medians of the turns count; of ratios, those of the turn's own.

- bare loop: `while True: handle(); sleep until the next deadline`
- manager: `BaseManager` with handlers that do the same
- call: a plain Python call, for scale
- queue hop: a message through `queue.Queue` to a thread that waits for it
"""

import queue
import resource
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from itertools import pairwise

from benchmarks.rig.turns import ratio, take_turns
from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.contracts.backend import BackendOptions
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Header

TURNS = 11
# One turn may be a third off on a machine that is shared.
CPU_TURNS, CPU_HZ, CPU_TICKS = 31, 200, 300
PERIOD_HZ, PERIOD_TICKS = 1000, 2000
MESSAGES = 50_000
HOPS = 3_000


def cpu_s() -> float:
    """CPU seconds of this process, all threads, system time included."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def run_bare(frequency_hz: float, ticks: int, handle: Callable[[], object]) -> float:
    """The loop that anyone would write. Gives the CPU seconds of its ticks."""
    period_s = 1.0 / frequency_hz
    before = cpu_s()
    deadline_s = time.monotonic()
    for _ in range(ticks):
        handle()
        deadline_s += period_s
        left_s = deadline_s - time.monotonic()
        if left_s > 0:
            time.sleep(left_s)
    return cpu_s() - before


def run_manager(frequency_hz: float, ticks: int, handle: Callable[[], object]) -> float:
    """A manager whose handlers do the same. Gives the CPU seconds of its ticks."""

    class Handlers(BaseHandlers):
        pass

    class App(BaseManager):
        def release_resources(self) -> None:
            self.after = cpu_s()

    Handlers.handle = staticmethod(handle)  # type: ignore[method-assign, assignment]  # handlers without a frame of their own
    app = App(handlers_class=Handlers, node_freq_hz=frequency_hz)
    app.backend.create_timer(ticks / frequency_hz, app.request_stop)
    before = cpu_s()
    app.start_main_loop_timer()
    return app.after - before


LOOPS = {"bare loop": run_bare, "manager": run_manager}


def loop_cpu(name: str) -> float:
    """Microseconds of CPU per tick of an empty handler."""
    return LOOPS[name](CPU_HZ, CPU_TICKS, lambda: None) / CPU_TICKS * 1e6


def loop_period(name: str) -> tuple[float, float, float]:
    """p50 and p99 of the period's error in microseconds, and how many periods had no tick.

    A machine that stalls for two periods leaves one without a tick, whoever loops.
    """
    starts: list[int] = []
    LOOPS[name](PERIOD_HZ, PERIOD_TICKS, lambda: starts.append(time.monotonic_ns()))
    period_ns = 1_000_000_000 // PERIOD_HZ
    errors = sorted(abs(b - a - period_ns) / 1000 for a, b in pairwise(starts))
    lost = sum(max(0, (b - a) // period_ns - 1) for a, b in pairwise(starts))
    return errors[len(errors) // 2], errors[len(errors) * 99 // 100], lost


class Pair(BaseNode):
    """Publishes to itself."""

    def __init__(self, backend: LocalBackend, callback: Callable[[Header], object]) -> None:
        super().__init__(backend=backend)
        self.publisher = self.create_publisher(Header, "topic")
        # All that may wait while the machine stalls.
        self.create_subscription(Header, "topic", callback, HOPS)


def message_call() -> float:
    """A plain call."""
    got: list[Header] = []

    def callback(message: Header) -> None:
        got.append(message)

    message, before = Header(), cpu_s()
    for _ in range(MESSAGES):
        callback(message)
    return (cpu_s() - before) / len(got) * 1e6


def message_publish() -> float:
    """From publish to callback on one thread."""
    got: list[Header] = []
    backend = LocalBackend(BackendOptions("bench"), Bus())
    publish, message = Pair(backend, got.append).publisher.publish, Header()
    before = cpu_s()
    for _ in range(MESSAGES):
        publish(message)
        backend.spin_once(0.0)
    return (cpu_s() - before) / len(got) * 1e6


def message_queue_hop() -> float:
    """To a thread that waits at a `queue.Queue`."""
    hop: queue.Queue[Header | None] = queue.Queue()
    got: list[Header] = []

    def receive() -> None:
        while (message := hop.get()) is not None:
            got.append(message)

    return _hops(receive, hop.put, lambda: hop.put(None), got)


def message_publish_hop() -> float:
    """From another thread to the one that spins."""
    got: list[Header] = []
    backend = LocalBackend(BackendOptions("bench"), Bus())
    pair = Pair(backend, got.append)
    ending: list[bool] = []

    def receive() -> None:
        backend.spin_until(time.monotonic_ns() + 10**11, lambda: bool(ending))

    return _hops(
        receive, pair.publisher.publish, lambda: backend.call_soon(lambda: ending.append(True)), got
    )


def _hops(
    receive: Callable[[], None],
    send: Callable[[Header], object],
    end: Callable[[], object],
    got: list[Header],
) -> float:
    """Sends at leisure, so that each message finds the receiver asleep."""
    receiver = threading.Thread(target=receive)
    receiver.start()
    message, before = Header(), cpu_s()
    for _ in range(HOPS):
        send(message)
        time.sleep(0.0005)
    took_s = cpu_s() - before
    end()
    receiver.join()
    assert len(got) == HOPS, f"lost {HOPS - len(got)}"
    return took_s / HOPS * 1e6


MESSAGE_ROWS = {
    "call": message_call,
    "publish to callback": message_publish,
    "queue hop": message_queue_hop,
    "publish from another thread": message_publish_hop,
}


def message_turn(name: str) -> float:
    """One turn of a row, in a process of its own: a queue of one is no business of the next."""
    command = [sys.executable, __file__, name]
    return float(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


def main() -> None:
    """Prints the tables."""
    cpu, period = take_turns(loop_cpu, LOOPS, CPU_TURNS), take_turns(loop_period, LOOPS, TURNS)
    p50s = {name: [p50 for p50, _, _ in turns] for name, turns in period.items()}
    print(
        f"{'':12}{f'us CPU/tick, {CPU_HZ} Hz':>22}{'of bare':>9}"
        f"{f'us p50 error, {PERIOD_HZ} Hz':>24}{'of bare':>9}{'p99':>8}{'lost':>6}"
    )
    for name in LOOPS:
        p50, p99, lost = (statistics.median(figures) for figures in zip(*period[name], strict=True))
        print(
            f"{name:12}{statistics.median(cpu[name]):22.1f}{ratio(cpu, name, 'bare loop'):9.2f}"
            f"{p50:24.1f}{ratio(p50s, name, 'bare loop'):9.2f}{p99:8.0f}{lost:6.0f}"
        )
    print(f"\n{'':30}{'us CPU/message':>16}")
    for name, figures in take_turns(message_turn, MESSAGE_ROWS, TURNS).items():
        print(f"{name:30}{statistics.median(figures):16.2f}")


if __name__ == "__main__":
    if len(sys.argv) == 2:
        print(MESSAGE_ROWS[sys.argv[1]]())
    else:
        main()
