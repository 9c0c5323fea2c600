"""A way to a broker on which packets can be lost without a word."""

import socket
import threading
from collections.abc import Callable

__all__ = ["StallingProxy"]

_TICK_S = 0.02


class StallingProxy:
    """Forwards connections; while it stalls it takes everything in and hands nothing on."""

    def __init__(self, port: int) -> None:
        """Listens, on behalf of a port of this machine."""
        self._target = port
        self._server = socket.create_server(("127.0.0.1", 0))
        self.port: int = self._server.getsockname()[1]
        self.is_stalling = False
        self._is_closed = False
        self._threads: list[threading.Thread] = []
        self._start(self._accept)

    def close(self) -> None:
        """Ends every connection."""
        self._is_closed = True
        for thread in self._threads:
            thread.join(20)
        self._server.close()

    def _start(self, function: Callable[..., object], *arguments: socket.socket) -> None:
        thread = threading.Thread(target=function, args=arguments)
        self._threads.append(thread)
        thread.start()

    def _accept(self) -> None:
        self._server.settimeout(_TICK_S)
        while not self._is_closed:
            try:
                near, _ = self._server.accept()
            except TimeoutError:
                continue
            self._start(self._forward, near)

    def _forward(self, near: socket.socket) -> None:
        with near, socket.create_connection(("127.0.0.1", self._target)) as far:
            ends = {near: far, far: near}
            for end in ends:
                end.settimeout(_TICK_S)
            is_lost = False
            while not self._is_closed:
                for source, target in ends.items():
                    try:
                        data = source.recv(65_536)
                    except TimeoutError:
                        continue
                    except OSError:
                        return
                    # A connection on which something was lost is lost for good.
                    is_lost = is_lost or self.is_stalling
                    if not is_lost:
                        if not data:
                            return
                        target.sendall(data)
                    elif not data and source is near:
                        return
