"""Where the sockets of this user's programs are.

A program makes its socket in `$XDG_RUNTIME_DIR/rosbase`, or in `/tmp/rosbase-<uid>`. Clients look
in both, because a service or a cron job has no XDG_RUNTIME_DIR. TMPDIR does not count: a program
and a client with two different ones could not find each other. ROSBASE_CONTROL_FOLDER takes the
place of both folders.

Only the standard library's `os` and `stat` are imported: commands start with this.
"""

import os
import stat

from rosbase.errors import ControlError

__all__ = ["MOST_PATH", "folders_to_read", "is_alive", "make_folder", "socket_path", "sockets"]

MOST_PATH = 107
"""Maximum length of the path of a socket, in bytes (`sun_path` of unix(7))."""
# The longest name: a pid has up to 10 digits.
_LONGEST_NAME = "/1234567890-9.sock"
_VARIABLE = "ROSBASE_CONTROL_FOLDER"
_TEMPORARY = "/tmp"
_OTHERS = stat.S_IRWXG | stat.S_IRWXO


def make_folder() -> str:
    """Return the folder for the socket of this process; make it if there is none.

    Raises:
        ControlError: It cannot be made, or is not this user's alone. The message says what to do.
    """
    path = _own_folder() or _under_runtime_dir() or _under_tmp()
    try:
        os.mkdir(path, 0o700)
    except FileExistsError:
        pass
    except OSError as error:
        raise ControlError(f"{path} cannot be made: {error.strerror}", "failed") from error
    if fault := _fault(path):
        raise ControlError(fault, "refused")
    return path


def socket_path(folder: str, pid: int, number: int = 0) -> str:
    """Return the path of a process's socket; the number is for several with one pid."""
    return f"{folder}/{pid}-{number}.sock" if number else f"{folder}/{pid}.sock"


def folders_to_read() -> list[str]:
    """Return the folders that exist and are this user's alone, for a client to look into.

    Raises:
        ControlError: The environment names one by a relative path.
    """
    return [path for path in _possible_folders() if not _fault(path)]


def sockets() -> list[tuple[int, str]]:
    """Return the pid and the path of each socket, by pid. Some may be stale.

    Raises:
        ControlError: There is none, but a folder that is not this user's alone, so that sockets in
            it do not count. The message says what to do.
    """
    found = []
    for folder in folders_to_read():
        try:
            names = os.listdir(folder)
        except OSError:
            # Removed meanwhile.
            continue
        for name in names:
            pid, dot, ending = name.partition(".")
            if dot and ending == "sock" and (number := pid.partition("-")[0]).isdecimal():
                found.append((int(number), f"{folder}/{name}"))
    if not found:
        _require_no_fault()
    return sorted(found)


def is_alive(pid: int) -> bool:
    """Return whether there is a process of that pid."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except OSError:
        pass
    return True


def _possible_folders() -> list[str]:
    if own := _own_folder():
        return [own]
    runtime, uid = os.environ.get("XDG_RUNTIME_DIR"), os.geteuid()
    return list(dict.fromkeys([f"{runtime or f'/run/user/{uid}'}/rosbase", _under_tmp()]))


def _require_no_fault() -> None:
    for path in _possible_folders():
        if os.path.lexists(path) and (fault := _fault(path)):
            raise ControlError(fault, "refused")


def _own_folder() -> str:
    path = os.environ.get(_VARIABLE, "").rstrip("/")
    if path and not os.path.isabs(path):
        raise ControlError(f"{_VARIABLE} is an absolute path, not {path!a}", "invalid")
    return path


def _under_runtime_dir() -> str:
    """Return the folder in XDG_RUNTIME_DIR; empty if there is none, or it is not to be used."""
    runtime = os.environ.get("XDG_RUNTIME_DIR", "")
    path = f"{runtime}/rosbase"
    if not os.path.isabs(runtime) or len(os.fsencode(path + _LONGEST_NAME)) > MOST_PATH:
        return ""
    try:
        found = os.stat(runtime)
    except OSError:
        return ""
    # `su` and `sudo -E` keep the variable of the user before.
    is_own = found.st_uid == os.geteuid() and not found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return path if is_own and stat.S_ISDIR(found.st_mode) else ""


def _under_tmp() -> str:
    return f"{_TEMPORARY}/rosbase-{os.geteuid()}"


def _fault(path: str) -> str:
    """Say why a folder is not this user's alone, and what to do; empty if it is."""
    try:
        found = os.lstat(path)
    except OSError as error:
        return f"{path}: {error.strerror}"
    if not stat.S_ISDIR(found.st_mode):
        kind = "a symbolic link" if stat.S_ISLNK(found.st_mode) else "no directory"
        return f"{path} is {kind}: remove it, and find out who has made it"
    if found.st_uid != os.geteuid():
        return f"{path} belongs to user {found.st_uid}: have it removed, or set XDG_RUNTIME_DIR"
    if found.st_mode & _OTHERS:
        return f"others may read {path}: run `chmod 700 {path}`"
    parent = os.stat(os.path.dirname(path))
    if parent.st_mode & stat.S_IWOTH and not parent.st_mode & stat.S_ISVTX:
        # Anybody could put another folder in its place.
        return f"others may replace {path}: run `chmod +t {os.path.dirname(path)}`"
    return ""
