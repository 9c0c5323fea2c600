"""Whole processes at another date, by Debian's faketime; the machine's own date is never set."""

import os
import shutil
import subprocess
from collections.abc import Mapping
from functools import cache
from pathlib import Path

import pytest

__all__ = ["FakeDate", "needs_faketime"]

needs_faketime = pytest.mark.skipif(
    shutil.which("faketime") is None, reason="faketime is not installed"
)

# libfaketime 0.9.10 fakes the monotonic clock as well, or else hands its deadlines to the system
# wrongly; Python's `time.sleep` alone waits for such a deadline. A lock does not.
_SLEEP = """
import threading
import time

def _sleep(seconds):
    lock = threading.Lock()
    lock.acquire()
    lock.acquire(timeout=seconds)

time.sleep = _sleep
"""


class FakeDate:
    """A date that processes take for that of the machine, and that may be set while they run."""

    def __init__(self, folder: Path, date: str) -> None:
        """Set the date.

        Args:
            folder: Where it is kept.
            date: As `2040-01-01 00:00:00`, in UTC.
        """
        self._file = folder / "faketime"
        self._site = folder / "site"
        self._site.mkdir()
        (self._site / "sitecustomize.py").write_text(_SLEEP)
        self.set(date)

    def set(self, date: str) -> None:
        """Set it; the processes notice within a second. An empty one is the machine's own."""
        written = self._file.with_suffix(".new")
        written.write_text(f"@{date}\n" if date else "+0\n")
        # At once: a file that is empty for a moment would be the machine's own date.
        written.replace(self._file)

    @property
    def variables(self) -> Mapping[str, str]:
        """The environment of a process that is to take it."""
        others = os.environ.get("PYTHONPATH")
        return {
            "LD_PRELOAD": _library(),
            "FAKETIME_TIMESTAMP_FILE": str(self._file),
            # Seconds. Looking at each call instead is not safe with threads.
            "FAKETIME_CACHE_DURATION": "1",
            "FAKETIME_DONT_FAKE_MONOTONIC": "1",
            "PYTHONPATH": os.pathsep.join(filter(None, [str(self._site), others])),
            "TZ": "UTC",
        }

    def command(self, *command: str, **variables: str) -> list[str]:
        """The command, at this date; only its process has the environment that this takes."""
        given = {**self.variables, **variables}
        return ["env", *(f"{name}={value}" for name, value in given.items()), *command]


@cache
def _library() -> str:
    """The library for programs with threads, beside the one that the command preloads."""
    done = subprocess.run(
        ["faketime", "2040-01-01", "env"], check=True, capture_output=True, text=True
    )
    (line,) = [text for text in done.stdout.splitlines() if text.startswith("LD_PRELOAD=")]
    return line.partition("=")[2].replace("libfaketime.so", "libfaketimeMT.so")
