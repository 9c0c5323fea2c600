"""What a view costs: 50 topics at 10 Hz, on a terminal of 160x50.

`nox -s bench -- view` runs it and prints a table. The view and the program are processes of their
own; the terminal is read by this one. The rows take turns; the medians of the turns count.

- alone: nobody looks
- view: `rosbase view`, on the page of topics
- bare: a line of textual that changes ten times a second, for comparison
"""

import fcntl
import os
import pty
import select
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import termios
import time
from pathlib import Path
from typing import Any

from attrs import frozen

from benchmarks.rig.turns import take_turns
from rosbase import BaseHandlers, BaseManager, BaseNode
from rosbase.messages import Point

TOPICS, RATE_HZ = 50, 10
COLUMNS, ROWS = 160, 50
WARM_UP_S, MEASURED_S = 3.0, 10.0
TURNS = 3


class Talker(BaseNode):
    """Publishes on many topics."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.out = [self.create_publisher(Point, f"point_{n:02d}") for n in range(TOPICS)]


class Handlers(BaseHandlers):
    """Publishes once on each topic, each tick."""

    def handle(self) -> None:
        for number, publisher in enumerate(self.node(Talker).out):
            publisher.publish(Point(float(self.timestamp), float(number)))


def observed() -> None:
    """The program."""
    manager = BaseManager("loop", {"talker": Talker}, {}, Handlers, node_freq_hz=RATE_HZ)
    manager.start_main_loop_timer()


def bare() -> None:
    """A line of textual that changes ten times a second."""
    from textual.app import App, ComposeResult
    from textual.widgets import Static

    class Bare(App[None]):
        def compose(self) -> ComposeResult:
            yield Static("0")

        def on_mount(self) -> None:
            self.number = 0
            self.set_interval(0.1, self.step)

        def step(self) -> None:
            self.number += 1
            self.query_one(Static).update(str(self.number))

    Bare().run()


@frozen
class Turn:
    """Shares of a processor in one turn of one row."""

    program: float
    view: float


def measure(what: str) -> Turn:
    """One turn."""
    with tempfile.TemporaryDirectory(prefix="rosbase-") as folder:
        environment = {**os.environ, "ROSBASE_CONTROL_FOLDER": folder}
        here = [sys.executable, str(Path(__file__))]
        program = subprocess.Popen([*here, "observed"], env=environment)
        command = {
            "alone": None,
            "view": [sys.executable, "-m", "rosbase", "view"],
            "bare": [*here, "bare"],
        }[what]
        try:
            time.sleep(1.0)
            return _watched(program, command, environment)
        finally:
            program.send_signal(signal.SIGINT)
            program.wait()


def _watched(
    program: "subprocess.Popen[bytes]", command: list[str] | None, environment: dict[str, str]
) -> Turn:
    own_end, far_end = pty.openpty()
    fcntl.ioctl(far_end, termios.TIOCSWINSZ, struct.pack("4H", ROWS, COLUMNS, 0, 0))
    view = None
    try:
        if command is not None:
            environment = {**environment, "TERM": "xterm-256color", "PYTHONUTF8": "1"}
            view = subprocess.Popen(
                command, stdin=far_end, stdout=far_end, stderr=far_end, env=environment
            )
        _read_for(own_end, WARM_UP_S)
        pids = [program.pid] + ([view.pid] if view else [])
        before = [_cpu_s(pid) for pid in pids]
        _read_for(own_end, MEASURED_S)
        used = [(_cpu_s(p) - b) / MEASURED_S for p, b in zip(pids, before, strict=True)]
        return Turn(used[0], used[1] if view else 0.0)
    finally:
        if view is not None:
            view.kill()
            view.wait()
        os.close(own_end)
        os.close(far_end)


def _read_for(fd: int, seconds: float) -> None:
    """Read what is written to the terminal, as a terminal does."""
    end_s = time.monotonic() + seconds
    while (left_s := end_s - time.monotonic()) > 0.0:
        if select.select([fd], [], [], left_s)[0]:
            os.read(fd, 65_536)


def _cpu_s(pid: int) -> float:
    """CPU time of a process, of all its threads."""
    tasks = Path(f"/proc/{pid}/task").glob("*/schedstat")
    return sum(int(task.read_text().split()[0]) for task in tasks) / 1e9


def main() -> None:
    """Print the table."""
    rows = take_turns(measure, ("alone", "view", "bare"), TURNS)
    print(f"{TOPICS} topics at {RATE_HZ} Hz, {COLUMNS}x{ROWS}; shares of a processor")
    print(f"{'':8}{'program':>10}{'view':>10}")
    for name, turns in rows.items():
        program = statistics.median(turn.program for turn in turns)
        view = statistics.median(turn.view for turn in turns)
        print(f"{name:8}{program:>10.1%}{view:>10.1%}")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        {"observed": observed, "bare": bare}[sys.argv[1]]()
    else:
        main()
