"""Run a program in the pane of a terminal multiplexer, under a guardian, when the launcher says so.

This is a separate script, started as `python -I -S pane.py SOCKET KEY`. It imports only the
standard library. It connects to the launcher, names its program, and waits for an order, which is
one line of JSON. The guardian then runs in the pane, so that it gets Ctrl-C and the end of the
pane, and uses the connection as its own to the launcher. When it has ended, the pane connects
again, for the next start. The order may also be to end, with a status that the pane shows.
"""

import json
import os
import signal
import socket
import sys

# Whatever else comes from the environment of the launcher, these belong to the pane.
_OF_THE_PANE = ("TERM", "TMUX", "TMUX_PANE", "COLORTERM")


def main() -> None:
    """Serve the launcher until it is gone, or says that this program has ended."""
    while True:
        # Ctrl-C before the start is for this process: the program is not wanted any more.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        try:
            with socket.socket(socket.AF_UNIX) as connection:
                connection.connect(sys.argv[1])
                connection.sendall(sys.argv[2].encode() + b"\n")
                order = json.loads(_line(connection))
                if "end" in order:
                    sys.exit(order["end"])
                guardian = _start(connection, order)
        except (OSError, ValueError):
            sys.exit("[rosbase] the launcher has ended")
        os.waitpid(guardian, 0)


def _line(connection: socket.socket) -> bytes:
    data = b""
    while not data.endswith(b"\n"):
        piece = connection.recv(65_536)
        if not piece:
            raise OSError("the launcher has ended")
        data += piece
    return data


def _start(connection: socket.socket, order: dict) -> int:  # type: ignore[type-arg]  # of JSON
    manager = os.getpid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    told, telling = os.pipe()
    pid = os.fork()
    if pid:
        os.close(told)
        # The launcher must know the guardian before the guardian itself says anything.
        connection.sendall(f"guardian {pid}\n".encode())
        os.close(telling)
        return pid
    try:
        os.close(telling)
        os.read(told, 1)
        os.close(told)
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        if order["cpus"]:
            os.sched_setaffinity(0, order["cpus"])
        os.set_inheritable(connection.fileno(), True)
        numbers = [str(connection.fileno()), str(manager), "-1"]
        own = {name: os.environ[name] for name in _OF_THE_PANE if name in os.environ}
        argv = [sys.executable, "-I", "-S", order["guardian"], *numbers, *order["argv"]]
        os.execve(argv[0], argv, order["environment"] | own)
    except BaseException as error:
        os.write(2, f"[rosbase] {error}\r\n".encode())
    os._exit(127)


if __name__ == "__main__":
    main()
