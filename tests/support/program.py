"""A program of a test's own, run as a process, with everything that descends from it."""

import os
import signal
import subprocess
import sys
import textwrap
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from support.log_lines import without_times
from support.stopwatch import Stopwatch
from support.waiting import wait_until

_MARK = "ROSBASE_TEST_PROGRAM"


class Program:
    """A running program. Whatever it starts inherits a mark, by which it is found."""

    def __init__(
        self,
        folder: Path,
        source: str,
        *arguments: str,
        options: Sequence[str] = (),
        cwd: Path | None = None,
        env: Mapping[str, str] | None = None,
        stdin: int | None = None,
    ) -> None:
        """Starts it from a file in the folder.

        Args:
            folder: Where the file `program.py` is written.
            source: What is in it.
            arguments: What it is given.
            options: Those of Python; `-m` at their end has it run as a module.
            cwd: Where it runs.
            env: What is added to its environment.
            stdin: A descriptor that it reads from.
        """
        file = folder / "program.py"
        file.write_text(textwrap.dedent(source))
        name = "program" if options[-1:] == ["-m"] else str(file)
        self.mark = f"{_MARK}={uuid.uuid4().hex}"
        self.process = subprocess.Popen(
            [sys.executable, "-W", "error", *options, name, *arguments],
            env={**os.environ, _MARK: self.mark.split("=")[1], **(env or {})},
            cwd=cwd,
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def read_until(self, text: str) -> None:
        """Reads its output up to a line that is this text."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if line.strip() == text:
                return
        raise AssertionError(f"it ended without {text!r}: {self.process.communicate()[1]}")

    def end(self) -> tuple[int, str, str]:
        """Waits for its end: status, the rest of its output, what it wrote to stderr.

        The lines of the log are without their times.
        """
        out, err = self.process.communicate(timeout=30)
        return self.process.returncode, out, without_times(err)

    def stop(self, signum: int) -> tuple[float, int, str, str]:
        """Sends a signal and waits: how long the end took in seconds, and what `end` gives."""
        with Stopwatch() as watch:
            self.process.send_signal(signum)
            status, out, err = self.end()
            return watch.took_s, status, out, err

    def family(self) -> dict[int, str]:
        """All processes that have its mark, and are not about to vanish, with their commands."""
        found = {}
        for folder in Path("/proc").iterdir():
            try:
                if folder.name.isdigit() and self.mark.encode() in _read(folder / "environ"):
                    state = _read(folder / "stat").rpartition(b")")[2].split()[0]
                    if state not in (b"Z", b"X"):
                        command = _read(folder / "cmdline").replace(b"\0", b" ").decode()
                        found[int(folder.name)] = command
            except OSError:
                continue
        return found


def _read(file: Path) -> bytes:
    return file.read_bytes()


@contextmanager
def running(folder: Path, source: str, *arguments: str, **options: Any) -> Iterator[Program]:
    """Runs the program, and leaves nothing of it behind, whatever the test does."""
    program = Program(folder, source, *arguments, **options)
    try:
        yield program
    finally:
        with program.process:
            for pid in program.family():
                os.kill(pid, signal.SIGKILL)
            program.process.communicate()
        wait_until(lambda: not program.family(), "the end of the program's processes")
