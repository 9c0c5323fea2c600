"""The manager's loop at 200 Hz while clients of its control socket behave well and badly.

`nox -s bench` runs it and prints a table. Each row is a process of its own, whose handlers log a
line in each tick. The rows take turns; the medians of the turns count.

- no socket: `ROSBASE_CONTROL=off`
- nobody asks: the socket, without a client
- never reads: a client that follows the log, and reads nothing
- reads: a client that follows the log, and reads it
- asks: a client that asks for the process and its statistics a hundred times a second
- left: a client that has followed the log, and has gone
"""

import json
import os
import socket
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

from benchmarks.rig.loops import SECONDS, WARM_UP_S, Handlers, Turn, print_table, read_turn
from benchmarks.rig.turns import take_turns
from rosbase import BaseManager

TURNS = 11
RATE_HZ = 200
# So long that all buffers are full when the warm-up is over.
LINE = "x" * 4_000
FOLLOW = {"id": 1, "ask": "log", "follow": True}


class Talking(Handlers):
    """Logs a line in each tick."""

    def handle(self) -> None:
        self.logger.info(LINE)
        super().handle()


def run(ticks: int, warm_up: int) -> None:
    """The program that is looked at."""
    BaseManager(
        "loop", handlers_class=Talking, node_freq_hz=RATE_HZ, warm_up=warm_up, ticks=ticks
    ).start_main_loop_timer()


def send(client: socket.socket, **frame: Any) -> None:
    """Sends a request."""
    client.sendall(json.dumps(frame).encode() + b"\n")


def never_reads(client: socket.socket, process: subprocess.Popen[str]) -> None:
    """Asks, and waits for the end of the program."""
    send(client, **FOLLOW)
    process.wait()


def reads(client: socket.socket, process: subprocess.Popen[str]) -> None:
    """Reads until the program ends."""
    send(client, **FOLLOW)
    while client.recv(65_536):
        pass


def asks(client: socket.socket, process: subprocess.Popen[str]) -> None:
    """Asks again and again."""
    with client.makefile("rb") as answers:
        answers.readline()
        try:
            while True:
                for name in ("process", "statistics"):
                    send(client, id=1, ask=name)
                    if not answers.readline():
                        return
                time.sleep(0.01)
        except OSError:
            pass


def leaves(client: socket.socket, process: subprocess.Popen[str]) -> None:
    """Reads a little, and goes."""
    send(client, **FOLLOW)
    client.recv(65_536)


Behaviour = Callable[[socket.socket, "subprocess.Popen[str]"], None]
ROWS: dict[str, Behaviour | None] = {
    "no socket": None,
    "nobody asks": None,
    "never reads": never_reads,
    "reads": reads,
    "asks": asks,
    "left": leaves,
}


def turn(name: str) -> Turn:
    """One turn of a row."""
    with tempfile.TemporaryDirectory(prefix="rb-") as folder:
        switch = "off" if name == "no socket" else "on"
        env = {**os.environ, "XDG_RUNTIME_DIR": folder, "ROSBASE_CONTROL": switch}
        command = [sys.executable, __file__, str(RATE_HZ * SECONDS), str(RATE_HZ * WARM_UP_S)]
        with subprocess.Popen(
            command, env=env, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        ) as process:
            behave = ROWS[name]
            if behave is not None:
                with connect(f"{folder}/rosbase/{process.pid}.sock") as client:
                    behave(client, process)
            out, _ = process.communicate()
    return read_turn(out, RATE_HZ)


def connect(path: str) -> socket.socket:
    """A connection to the program, while it warms up."""
    while not os.path.exists(path):
        time.sleep(0.01)
    client = socket.socket(socket.AF_UNIX)
    client.connect(path)
    return client


def main() -> None:
    """Prints the table."""
    print_table(f"{RATE_HZ} Hz", take_turns(turn, ROWS, TURNS), "nobody asks")


if __name__ == "__main__":
    if len(sys.argv) == 3:
        run(*map(int, sys.argv[1:]))
    else:
        main()
