"""The page: the server, what it shows, and the loop that keeps it up to date."""

import threading
from queue import Empty, SimpleQueue
from socket import socket

from rosbase import Clock
from rosbase_view.source import Gaze, Source
from rosbase_view.web.model import Model, Press
from rosbase_view.web.panel import Panel
from rosbase_view.web.player import Played, PlayOrPause, Seek, play
from rosbase_view.web.scene import Scene
from rosbase_view.web.server import GuardedServer

__all__ = ["Page"]

_EVERY_S = 0.05
_IDLE_S = 0.25
_PLOTS_EVERY_NS = 200_000_000


class Page:
    """Shows a source to all browsers that connect. While there is none, it asks for nothing."""

    def __init__(self, source: Source, listening: socket, token: str, clock: Clock) -> None:
        """Serve the page. `run` fills it.

        Args:
            source: What is shown; it was not started yet.
            listening: Socket of the page, which the page closes.
            token: The token in its address.
            clock: The clock.
        """
        self._source, self._clock = source, clock
        self._model = Model()
        self._presses: SimpleQueue[Press | Played] = SimpleQueue()
        self._ended = threading.Event()
        self._server = GuardedServer(listening, token, "rosbase view")
        self._scene = Scene(self._server)
        self._panel = Panel(self._server, self._presses.put, can_change=source.can_change)
        self._gaze = Gaze()
        self._topic = ""
        self._has_begun = False
        self._plots_ns = clock.monotonic_ns()

    def run(self) -> None:
        """Keep the page up to date, until `end` or an error such as KeyboardInterrupt."""
        self._source.start()
        try:
            while not self._ended.wait(self._step()):
                pass
        finally:
            self._source.close()
            self._server.stop()

    def end(self) -> None:
        """End `run`. Any thread may do so."""
        self._ended.set()

    def _step(self) -> float:
        """Take what is new, and show it; return the seconds until the next step."""
        now_ns = self._clock.monotonic_ns()
        has_browser = bool(self._server.get_clients())
        self._model.take(self._source.take(), now_ns)
        self._take_presses(now_ns)
        self._look(self._model.gaze if has_browser else Gaze())
        if not has_browser:
            return _IDLE_S
        if not self._has_begun:
            self._begin()
        picture = self._model.picture(now_ns)
        if picture.topic != self._topic:
            self._topic = picture.topic
            self._scene.level()
        self._scene.show(picture.rotation)
        with_plots = now_ns - self._plots_ns >= _PLOTS_EVERY_NS
        if with_plots:
            self._plots_ns = now_ns
        self._panel.show(picture, with_plots=with_plots)
        return _EVERY_S

    def _begin(self) -> None:
        """Play a recording, now that somebody sees it."""
        self._has_begun = True
        if self._source.playback is not None:
            self._source.playback.play()

    def _take_presses(self, now_ns: int) -> None:
        while True:
            try:
                press = self._presses.get_nowait()
            except Empty:
                return
            if isinstance(press, PlayOrPause | Seek):
                self._play(press)
            elif (change := self._model.press(press, now_ns)) is not None:
                self._source.change(change)

    def _play(self, played: Played) -> None:
        playback, position = self._source.playback, self._model.known.position
        if playback is not None and position is not None:
            play(played, playback, position)

    def _look(self, gaze: Gaze) -> None:
        if gaze != self._gaze:
            self._gaze = gaze
            self._model.known.forget_unseen(gaze)
            self._source.look_at(gaze)
