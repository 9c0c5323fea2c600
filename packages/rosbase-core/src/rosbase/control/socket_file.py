"""The socket of this process in the file system: made, found stale, removed."""

import os
import socket
import stat

from rosbase.control.folder import is_alive, make_folder, socket_path
from rosbase.errors import ControlError

__all__ = ["SocketFile", "refuses", "remove_strays"]

_MODE = 0o600
_BACKLOG = 128
# Processes with one pid, of several containers that share the folder.
_MOST_PER_PID = 9
_MOST_STRAYS = 1_000


class SocketFile:
    """A listening socket, and its name."""

    def __init__(self) -> None:
        """Open it.

        Raises:
            ControlError: The folder cannot be used.
            OSError: The socket cannot be made.
        """
        self.folder = make_folder()
        self._path = self._choose_path()
        self.listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            self.listener.settimeout(0)
            # Linux gives the file the mode of the socket, so that it has no other one first.
            os.fchmod(self.listener.fileno(), _MODE)
            self._inode = self._listen()
        except BaseException:
            self.listener.close()
            raise

    def remove(self) -> None:
        """Remove the name, unless it has become another socket's."""
        try:
            if os.lstat(self._path).st_ino == self._inode:
                os.unlink(self._path)
        except OSError:
            # Somebody has cleaned up.
            pass

    def _listen(self) -> int:
        """Listen, and only then take the name; return the inode.

        A socket that does not listen yet refuses clients, which take it for one that was left
        behind, and remove it.
        """
        # Not a name that clients look for, and no longer than the longest of those.
        new = f"{self.folder}/{os.getpid()}.{os.urandom(3).hex()}"
        self.listener.bind(new)
        try:
            os.chmod(new, _MODE)
            self.listener.listen(_BACKLOG)
            inode = os.lstat(new).st_ino
            os.rename(new, self._path)
        except BaseException:
            _remove_socket(new)
            raise
        return inode

    def _choose_path(self) -> str:
        pid = os.getpid()
        for number in range(_MOST_PER_PID + 1):
            path = socket_path(self.folder, pid, number)
            # One of this pid is of a process before, unless that lives in another container.
            if not os.path.lexists(path):
                return path
            if refuses(path):
                try:
                    os.unlink(path)
                except FileNotFoundError:
                    # Another process has found it too.
                    pass
                return path
        raise ControlError(f"{_MOST_PER_PID} sockets of process {pid} are in use in {self.folder}")


def refuses(path: str) -> bool:
    """Return whether nobody listens at a socket."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.settimeout(0)
        try:
            probe.connect(path)
        except ConnectionRefusedError:
            return True
        except OSError:
            # As if its queue were full.
            return False
    return False


def remove_strays(folder: str) -> None:
    """Remove the sockets of processes that are gone, also those without their last name."""
    for name in os.listdir(folder)[:_MOST_STRAYS]:
        number = name.partition(".")[0].partition("-")[0]
        if not ("." in name and number.isdecimal()):
            continue
        path = f"{folder}/{name}"
        # A living process keeps its sockets. One that seems gone may live in another container.
        if not is_alive(int(number)) and refuses(path):
            _remove_socket(path)


def _remove_socket(path: str) -> None:
    try:
        found = os.lstat(path)
        if stat.S_ISSOCK(found.st_mode):
            os.unlink(path)
    except OSError:
        # Another process has found it too.
        pass
