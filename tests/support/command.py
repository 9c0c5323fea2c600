"""The command `rosbase` as a process of its own, as a user runs it."""

import os
import subprocess
import sys
import threading
from pathlib import Path
from types import TracebackType
from typing import IO

from support.waiting import wait_until

ROSBASE = str(Path(sys.executable).with_name("rosbase"))


def run_rosbase(*arguments: str, timeout_s: float = 40.0) -> subprocess.CompletedProcess[str]:
    """Runs it to its end."""
    return subprocess.run(
        [ROSBASE, *arguments],
        capture_output=True,
        text=True,
        timeout=timeout_s,
        check=False,
    )


def run_apart(
    *arguments: str, path: Path | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    """Runs it with nothing of the user's environment.

    Args:
        arguments: Those of the command.
        path: A folder with more plugins.
        variables: The environment.
    """
    code = "import sys; from rosbase.cli import main; sys.exit(main())"
    # Where the modules come from is no affair of the user's.
    folders = [str(path or ""), os.environ.get("PYTHONPATH", "")]
    own = {"PYTHONPATH": os.pathsep.join(filter(None, folders)), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        timeout=40,
        env={"PATH": "", **own, **variables},
        check=False,
    )


class Lines:
    """What a process has printed so far, read by a thread so that the process never waits."""

    def __init__(self, stream: IO[str]) -> None:
        self.lines: list[str] = []
        self._thread = threading.Thread(target=self._read, args=(stream,))
        self._thread.start()

    def _read(self, stream: IO[str]) -> None:
        for line in stream:
            self.lines.append(line.rstrip("\n"))

    def join(self) -> None:
        self._thread.join(20)

    def count(self, part: str) -> int:
        return sum(part in line for line in self.lines)

    def __contains__(self, part: str) -> bool:
        return any(part in line for line in self.lines)


class RunningRosbase:
    """A `rosbase` that runs until it is told to end."""

    def __init__(self, *arguments: str, program: str = ROSBASE) -> None:
        self.process = subprocess.Popen(
            [program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        assert self.process.stderr is not None
        self.out, self.err = Lines(self.process.stdout), Lines(self.process.stderr)

    def __enter__(self) -> "RunningRosbase":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self.process.poll() is None:
            self.process.kill()
        self.end()

    def waits_for(self, part: str, *, where: Lines | None = None) -> None:
        """Returns when it has printed that, to stderr or to `where`."""
        lines = self.err if where is None else where
        try:
            wait_until(lambda: part in lines, repr(part))
        except AssertionError as error:
            raise AssertionError(f"{error}, not only {lines.lines}") from None

    def end(self, signum: int | None = None) -> int:
        """Sends the signal, if there is one, and gives the exit status."""
        if signum is not None:
            self.process.send_signal(signum)
        status = self.process.wait(20)
        self.out.join()
        self.err.join()
        for stream in (self.process.stdout, self.process.stderr):
            assert stream is not None
            stream.close()
        return status


def summary_of(lines: list[str]) -> dict[str, float]:
    """The counts at the end of a run: the word first, then the number."""
    found = {}
    for line in lines:
        words = line.split()
        if len(words) == 2 and words[1].replace(".", "", 1).isdigit():
            found[words[0]] = float(words[1])
    return found
