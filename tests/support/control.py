"""A plain client of control sockets, written from the description of the protocol."""

import json
import os
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosbase.control.programs import Program, offered
from rosbase.control.streams import Stream
from rosbase.logger import RosbaseLogger
from support.waiting import wait_until

PATIENCE_S = 20.0


class Asker:
    """One connection to a socket."""

    def __init__(self, path: str) -> None:
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(PATIENCE_S)
        try:
            self.socket.connect(path)
        except OSError:
            self.socket.close()
            raise
        self._file = self.socket.makefile("rb")
        self._number = 0
        self.hello = self.read()[0]

    def __enter__(self) -> "Asker":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the connection."""
        self._file.close()
        self.socket.close()

    def read(self) -> tuple[dict[str, Any], bytes]:
        """Waits for the next frame."""
        line = self._file.readline()
        if not line.endswith(b"\n"):
            raise EOFError(f"the connection was closed after {line!r}")
        frame = json.loads(line)
        return frame, self._file.read(frame.get("bytes", 0))

    def send(self, ask: str, data: bytes = b"", **arguments: Any) -> int:
        """Sends a request; gives its number."""
        self._number += 1
        frame = {"id": self._number, "ask": ask, **arguments}
        if data:
            frame["bytes"] = len(data)
        self.socket.sendall(json.dumps(frame).encode() + b"\n" + data)
        return self._number

    def ask(self, ask: str, data: bytes = b"", **arguments: Any) -> dict[str, Any]:
        """Sends a request; gives what is in `ok`."""
        answer = self.answer(ask, data, **arguments)
        assert "ok" in answer, answer
        return dict(answer["ok"])

    def answer(self, ask: str, data: bytes = b"", **arguments: Any) -> dict[str, Any]:
        """Sends a request; gives the whole answer."""
        number = self.send(ask, data, **arguments)
        frame, _ = self.read()
        assert frame["id"] == number, frame
        return frame

    def is_closed(self) -> bool:
        """Waits until the other side has ended the connection; leaves out what it has sent."""
        try:
            while self._file.read(65_536):
                pass
        except ConnectionResetError:
            pass
        return True


class FakeProgram(Program):
    """A program without anything, and with answers of its own."""

    kind = "launcher"

    def __init__(self, **answers: Any) -> None:
        self.own = answers
        self.stops = 0

    @property
    def name(self) -> str:
        return "/fake"

    def answers(self) -> dict[str, Any]:
        return self.own

    def request_stop(self) -> None:
        self.stops += 1


class Endless(Stream):
    """Events without an end, each with a payload."""

    def __init__(self, size: int = 0, most: int = 10**9) -> None:
        self.ok = {}
        self.size = size
        self.most = most
        self.taken = 0
        self.is_closed = False

    def take(self) -> tuple[dict[str, Any], bytes] | None:
        if self.taken >= self.most:
            return None
        self.taken += 1
        return {"n": self.taken}, b"x" * self.size

    def close(self) -> None:
        self.is_closed = True


@contextmanager
def offering(program: Program | None = None) -> Iterator[str]:
    """Offers a program in this process; gives the path of the socket."""
    with offered(program or FakeProgram(), RosbaseLogger("test")):
        yield own_socket()


def own_socket() -> str:
    """The path of the socket of this process."""
    return socket_of(None)


def socket_of(pid: int | None) -> str:
    """The path of the socket of a process; of this one, if none is given."""
    folder = Path(os.environ["XDG_RUNTIME_DIR"], "rosbase")
    return str(folder / f"{os.getpid() if pid is None else pid}.sock")


def connected(pid: int | None = None) -> Asker:
    """A connection to a process, or to this one, as soon as it listens."""
    found: list[Asker] = []

    def is_there() -> bool:
        try:
            found.append(Asker(socket_of(pid)))
        except (FileNotFoundError, ConnectionRefusedError):
            return False
        return True

    wait_until(is_there, "the socket")
    return found[0]


def ask_while_running(
    manager: Any, questions: Callable[[Asker], None], *, until: str = "running"
) -> None:
    """Runs a manager or a lone node, and asks questions on another thread.

    Args:
        manager: What runs. It is stopped afterwards.
        questions: Called with a connection.
        until: The phase that is waited for before.
    """
    failures: list[BaseException] = []

    def ask() -> None:
        try:
            with connected() as client:
                wait_until(lambda: client.ask("process")["programs"][0]["phase"] == until, until)
                questions(client)
        except BaseException as error:
            failures.append(error)
        finally:
            manager.request_stop()

    thread = threading.Thread(target=ask)
    thread.start()
    try:
        run = getattr(manager, "start_main_loop_timer", None) or manager.start_spin_standalone
        run()
    finally:
        thread.join()
    if failures:
        raise failures[0]
