"""The panes of a run: each waits on a connection for the next start of its program."""

import json
import os
import select
import shlex
import shutil
import socket
import sys
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosbase.clock import Clock
from rosbase.launcher.description import Program
from rosbase.launcher.tmux.client import Pane, Tmux
from rosbase.processes.guardian import stat_of

__all__ = ["Panes", "opened"]

_PANE_SCRIPT = str(Path(__file__).with_name("pane.py"))
_PREFIX = "rosbase-up-"
_PATIENCE_NS = 10_000_000_000
_MOST_KEY_BYTES = 4096


class Panes:
    """Opens panes, and gives orders to the scripts that run in them. From any thread."""

    def __init__(self, tmux: Tmux, folder: Path, clock: Clock) -> None:
        """Listen in a folder that only this user can enter."""
        self._tmux = tmux
        self._folder = folder
        self._clock = clock
        self._lock = threading.RLock()
        self._panes: dict[str, Pane] = {}
        self._sessions: set[str] = set()
        # Panes that wait for an order.
        self._waiting: dict[str, socket.socket] = {}
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(folder / "panes"))
        self._listener.listen(64)
        self._listener.settimeout(0.0)

    def close(self) -> None:
        """Stop listening; the panes that wait end."""
        with self._lock:
            for connection in self._waiting.values():
                connection.close()
            self._waiting.clear()
            self._listener.close()

    def open(self, program: Program) -> None:
        """Open the pane of a program, or run the script in it again.

        Raises:
            OSError: tmux refuses.
        """
        command = shlex.join(
            [sys.executable, "-I", "-S", _PANE_SCRIPT, str(self._folder / "panes"), program.key]
        )
        folder = str(program.folder)
        with self._lock:
            old = self._panes.get(program.key)
            if old is not None:
                try:
                    self._tmux.respawn(old, f"exec {command}")
                    return
                except OSError:
                    # Somebody has closed it.
                    pass
            if program.session in self._sessions and self._tmux.has_session(program.session):
                pane = self._tmux.add_pane(program.session, folder, f"exec {command}")
            else:
                pane = self._tmux.new_session(program.session, folder, f"exec {command}")
                self._sessions.add(program.session)
                self._tmux.note(program.session, "rosbase_launcher", str(os.getpid()))
            self._tmux.name_pane(pane, program.name)
            self._panes[program.key] = pane

    def take(self, program: Program) -> socket.socket:
        """Return the connection to the pane of a program; open the pane if there is none.

        Raises:
            OSError: tmux refuses, or the pane does not come.
        """
        ends_ns = self._clock.monotonic_ns() + _PATIENCE_NS
        with self._lock:
            self._drop_closed()
            if program.key not in self._waiting and not self._comes_soon(program.key):
                self.open(program)
            while program.key not in self._waiting:
                left_ns = ends_ns - self._clock.monotonic_ns()
                if left_ns <= 0:
                    raise OSError("its pane does not answer")
                select.select([self._listener], [], [], min(0.1, left_ns / 1e9))
                self._accept()
            return self._waiting.pop(program.key)

    def finish(self, key: str, status: int) -> None:
        """End the script in a pane, which stays readable and shows the status."""
        with self._lock:
            self._accept()
            connection = self._waiting.pop(key, None)
            if connection is None and self._comes_soon(key):
                connection = self._waiting.pop(key, None)
            if connection is not None:
                with connection:
                    give(connection, {"end": status})

    def closed(self) -> list[str]:
        """Return the keys of the panes that were closed while they waited for an order."""
        with self._lock:
            self._accept()
            return self._drop_closed()

    def write(self, key: str, line: str) -> None:
        """Write a line into the pane of a program, as far as it takes it at once."""
        pane = self._panes.get(key)
        if pane is None:
            return
        try:
            terminal = os.open(pane.terminal, os.O_WRONLY | os.O_NONBLOCK | os.O_NOCTTY)
        except OSError:
            # It is closed.
            return
        try:
            os.write(terminal, f"{line}\r\n".encode(errors="replace"))
        except OSError:
            # Somebody has stopped it with Ctrl-S, or it is closed.
            pass
        finally:
            os.close(terminal)

    def tap(self, key: str) -> int:
        """Return a descriptor that delivers the output of a pane as well.

        Raises:
            OSError: tmux refuses.
        """
        path = self._folder / f"output{list(self._panes).index(key)}"
        if not path.exists():
            os.mkfifo(path, 0o600)
        output = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        try:
            self._tmux.copy_output(self._panes[key], f"exec cat > {shlex.quote(str(path))}")
        except BaseException:
            os.close(output)
            raise
        return output

    def _comes_soon(self, key: str) -> bool:
        """Return whether the script in a pane has just ended a run, and connects again."""
        pane = self._panes.get(key)
        if pane is None:
            return False
        ends_ns = self._clock.monotonic_ns() + _PATIENCE_NS // 10
        while key not in self._waiting and self._clock.monotonic_ns() < ends_ns:
            state = self._tmux.run("display-message", "-p", "-t", pane.number, "#{pane_dead}")
            if state.strip() != "0":
                return False
            select.select([self._listener], [], [], 0.1)
            self._accept()
        return key in self._waiting

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            key = _read_line(connection, 1.0).decode(errors="replace")
            old = self._waiting.pop(key, None)
            if old is not None:
                old.close()
            if key:
                self._waiting[key] = connection
            else:
                connection.close()

    def _drop_closed(self) -> list[str]:
        gone = [key for key, connection in self._waiting.items() if _is_closed(connection)]
        for key in gone:
            self._waiting.pop(key).close()
        return gone


def give(connection: socket.socket, order: Mapping[str, Any]) -> None:
    """Send an order to a pane; do nothing if it is closed."""
    connection.settimeout(1.0)
    try:
        connection.sendall(json.dumps(order).encode() + b"\n")
    except OSError:
        # The launcher notices when it reads the answer, or has nothing more to say.
        pass


def read_guardian(connection: socket.socket) -> int:
    """Return the process id of the guardian that a pane has started.

    Raises:
        OSError: The pane has ended.
    """
    word, _, number = _read_line(connection, 5.0).partition(b" ")
    if word != b"guardian" or not number.isdigit():
        raise OSError("its pane is closed")
    return int(number)


@contextmanager
def opened(tmux: Tmux, clock: Clock) -> Iterator[Panes]:
    """Provide panes; at the end, the scripts in them end and the panes stay."""
    _clear_away_dead()
    with tempfile.TemporaryDirectory(prefix=f"{_PREFIX}{os.getpid()}-") as folder:
        panes = Panes(tmux, Path(folder), clock)
        try:
            yield panes
        finally:
            panes.close()


def _clear_away_dead() -> None:
    """Remove the folders of launchers that were killed."""
    for folder in Path(tempfile.gettempdir()).glob(f"{_PREFIX}*"):
        number = folder.name.removeprefix(_PREFIX).partition("-")[0]
        try:
            is_ours = folder.lstat().st_uid == os.getuid()
        except OSError:
            # Somebody else has just removed it.
            continue
        if is_ours and number.isdecimal() and not stat_of(number):
            shutil.rmtree(folder, ignore_errors=True)


def _read_line(connection: socket.socket, timeout_s: float) -> bytes:
    """Return a line byte by byte: what follows belongs to somebody else. Empty on any trouble."""
    connection.settimeout(timeout_s)
    line = b""
    try:
        while len(line) < _MOST_KEY_BYTES:
            byte = connection.recv(1)
            if byte in (b"", b"\n"):
                return line if byte else b""
            line += byte
    except OSError:
        pass
    return b""


def _is_closed(connection: socket.socket) -> bool:
    connection.settimeout(0.0)
    try:
        return connection.recv(1, socket.MSG_PEEK) == b""
    except BlockingIOError:
        return False
    except OSError:
        return True
