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
# A socket's path has at most 107 bytes: unix(7).
_LONGEST_FOLDER = 70
_PATIENCE_NS = 10_000_000_000
_LOOK_AGAIN_S = 0.05
_ANSWER_S = 10.0
_MOST_KEY_BYTES = 4096


class Panes:
    """Opens panes, and gives orders to the scripts that run in them. From any thread."""

    def __init__(
        self, tmux: Tmux, folder: Path, clock: Clock, sizes: Mapping[str, tuple[int, int]]
    ) -> None:
        """Listen in a folder that only this user can enter. New sessions get the given sizes."""
        self._tmux = tmux
        self._folder = folder
        self._clock = clock
        self._lock = threading.RLock()
        self._panes: dict[str, Pane] = {}
        # When the terminal of each was made: later, its path may name another terminal.
        self._made_ns: dict[str, int] = {}
        self._sizes = sizes
        self._sessions: set[str] = set()
        # New connections, and panes that wait for an order.
        self._nameless: list[socket.socket] = []
        self._waiting: dict[str, socket.socket] = {}
        # Statuses for the scripts that are to end as soon as they connect again.
        self._ends: dict[str, int] = {}
        # Programs whose scripts are ending; tmux is to notice.
        self._ending: set[str] = set()
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(str(folder / "panes"))
        self._listener.listen(64)
        self._listener.settimeout(0.0)

    def close(self) -> None:
        """Stop listening; the panes that wait end."""
        with self._lock:
            for connection in [*self._nameless, *self._waiting.values()]:
                connection.close()
            self._nameless.clear()
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
                    self._note(program.key, self._tmux.respawn(old, f"exec {command}"))
                    return
                except OSError:
                    # Somebody has closed it.
                    pass
            if program.session in self._sessions and self._tmux.has_session(program.session):
                pane = self._tmux.add_pane(program.session, folder, f"exec {command}")
            else:
                size = self._sizes[program.session]
                pane = self._tmux.new_session(program.session, folder, f"exec {command}", size)
                self._sessions.add(program.session)
                self._tmux.note(program.session, "rosbase_launcher", str(os.getpid()))
            self._tmux.name_pane(pane, program.name)
            self._note(program.key, pane)

    def take(self, program: Program) -> socket.socket:
        """Return the connection to the pane of a program; open the pane if there is none.

        Raises:
            OSError: tmux refuses, or the pane does not come.
        """
        key = program.key
        ends_ns = self._clock.monotonic_ns() + _PATIENCE_NS
        with self._lock:
            self._ends.pop(key, None)
            self._ending.discard(key)
            self._accept()
            self._drop_closed()
            if key not in self._waiting and not self._is_alive(key):
                self.open(program)
        while self._clock.monotonic_ns() < ends_ns:
            with self._lock:
                self._accept()
                if key in self._waiting:
                    return self._waiting.pop(key)
            select.select([self._listener], [], [], _LOOK_AGAIN_S)
        raise OSError("its pane does not answer")

    def finish(self, key: str, status: int) -> None:
        """End the script in a pane, which stays readable and shows the status."""
        with self._lock:
            self._ends[key] = status
            self._accept()
            self._tell_ends()

    def drain(self) -> None:
        """Wait until the scripts that are to end have been told so, for a limited time."""
        ends_ns = self._clock.monotonic_ns() + _PATIENCE_NS
        while self._clock.monotonic_ns() < ends_ns:
            with self._lock:
                self._accept()
                self._tell_ends()
                if not any(self._is_alive(key) for key in [*self._ends, *self._ending]):
                    break
            select.select([self._listener], [], [], _LOOK_AGAIN_S)
        self._tmux.look_for_ends()

    def closed(self) -> list[str]:
        """Return the keys of the panes that were closed while they waited for an order."""
        with self._lock:
            self._accept()
            self._tell_ends()
            if self._ending and not any(map(self._is_alive, self._ending)):
                self._ending.clear()
                self._tmux.look_for_ends()
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
            if os.fstat(terminal).st_ctime_ns == self._made_ns[key]:
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

    def _note(self, key: str, pane: Pane) -> None:
        self._panes[key] = pane
        try:
            self._made_ns[key] = os.stat(pane.terminal).st_ctime_ns
        except OSError:
            # It is closed already.
            self._made_ns[key] = 0

    def _is_alive(self, key: str) -> bool:
        """Return whether the script in a pane runs; it may be about to connect again."""
        pane = self._panes.get(key)
        return pane is not None and self._tmux.is_alive(pane)

    def _tell_ends(self) -> None:
        for key in self._ends.keys() & self._waiting.keys():
            with self._waiting.pop(key) as connection:
                give(connection, {"end": self._ends.pop(key)})
            self._ending.add(key)

    def _accept(self) -> None:
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                break
            connection.settimeout(0.0)
            self._nameless.append(connection)
        self._learn_names()

    def _learn_names(self) -> None:
        """Read the keys that new connections have sent by now."""
        nameless, self._nameless = self._nameless, []
        for connection in nameless:
            try:
                key = connection.recv(_MOST_KEY_BYTES).decode(errors="replace").rstrip("\n")
            except BlockingIOError:
                self._nameless.append(connection)
                continue
            except OSError:
                key = ""
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
    word, _, number = _read_line(connection).partition(b" ")
    if word != b"guardian" or not number.isdigit():
        raise OSError("its pane is closed")
    return int(number)


@contextmanager
def opened(tmux: Tmux, clock: Clock, sizes: Mapping[str, tuple[int, int]]) -> Iterator[Panes]:
    """Provide panes; at the end, the scripts in them end and the panes stay.

    Args:
        tmux: The server.
        clock: The clock.
        sizes: Columns and lines of each session.
    """
    _clear_away_dead()
    with tempfile.TemporaryDirectory(prefix=f"{_PREFIX}{os.getpid()}-", dir=_temporary()) as folder:
        panes = Panes(tmux, Path(folder), clock, sizes)
        try:
            yield panes
        finally:
            panes.close()


def _temporary() -> str:
    """Return the folder for temporary files, unless the path of a socket in it is too long."""
    usual = tempfile.gettempdir()
    return usual if len(os.fsencode(usual)) <= _LONGEST_FOLDER else "/tmp"


def _clear_away_dead() -> None:
    """Remove the folders of launchers that were killed."""
    for folder in Path(_temporary()).glob(f"{_PREFIX}*"):
        number = folder.name.removeprefix(_PREFIX).partition("-")[0]
        try:
            is_ours = folder.lstat().st_uid == os.getuid()
        except OSError:
            # Somebody else has just removed it.
            continue
        if is_ours and number.isdecimal() and not stat_of(number):
            shutil.rmtree(folder, ignore_errors=True)


def _read_line(connection: socket.socket) -> bytes:
    """Return a line byte by byte: what follows belongs to somebody else. Empty on any trouble."""
    connection.settimeout(_ANSWER_S)
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
