"""Processes as the system has them, for tests of children and of what descends from them."""

import os
import signal
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from support.waiting import wait_until

_DEAD = "ZX"


class Token:
    """A word in the command lines of a test's processes, by which all of them are found.

    Neither another session, nor another parent, nor another environment hides them from it.
    """

    def __init__(self) -> None:
        # A number, so that it can be a time for sleep(1) to sleep: longer than any test.
        self.text = f"9{uuid.uuid4().int % 10**8:08d}"

    def bearers(self) -> dict[int, str]:
        """The processes that are alive, with their command lines."""
        found = {}
        for pid in _alive():
            command = _read(pid, "cmdline").replace(b"\0", b" ").decode(errors="replace")
            if self.text in command and pid != os.getpid():
                found[pid] = command.strip()
        return found

    def sleepers(self) -> list[int]:
        """Those of them that are the command sleep(1), and not a shell or a guardian of it."""
        return [pid for pid, text in self.bearers().items() if text == f"sleep {self.text}"]

    def wait_for_sleepers(self, number: int) -> list[int]:
        """Waits until so many of them sleep, and gives them."""
        wait_until(lambda: len(self.sleepers()) == number, f"{number} sleepers")
        return self.sleepers()

    def wait_until_gone(self, timeout_s: float = 20.0) -> None:
        """Waits until nobody bears it."""
        try:
            wait_until(lambda: not self.bearers(), "the end of all", timeout_s)
        except AssertionError:
            raise AssertionError(f"after {timeout_s} s alive: {self.bearers()}") from None


@contextmanager
def bearers_of_a_token() -> Iterator[Token]:
    """Gives a token; whoever bears it at the end is killed, whatever the test does."""
    token = Token()
    try:
        yield token
    finally:
        while bearers := token.bearers():
            for pid in bearers:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    # It has ended meanwhile.
                    continue


def parent_of(pid: int) -> int:
    """The parent of a process."""
    return int(_stat(pid)[1])


def members_of_session(leader: int) -> list[int]:
    """Everybody in the session of that process who has not ended."""
    return [pid for pid in _alive() if _stat(pid)[3] == str(leader)]


def state_of(pid: int) -> str:
    """The state of a process as one letter: T is stopped, Z is a zombie, nothing is gone."""
    return _stat(pid)[0]


def _alive() -> list[int]:
    return [
        int(folder.name)
        for folder in Path("/proc").iterdir()
        if folder.name.isdigit() and not _has_ended(_stat(int(folder.name)))
    ]


def _has_ended(stat: list[str]) -> bool:
    # Whose main thread has ended before the others is a zombie with more than one thread.
    return not stat[0] or (stat[0] in _DEAD and int(stat[17]) <= 1)


def _stat(pid: int) -> list[str]:
    """State, parent, group, session and so on; nothing in each of them if it has ended."""
    fields = _read(pid, "stat").decode(errors="replace").rpartition(")")[2].split()
    return fields or [""] * 50


def _read(pid: int, name: str) -> bytes:
    try:
        return Path(f"/proc/{pid}/{name}").read_bytes()
    except OSError:
        return b""
