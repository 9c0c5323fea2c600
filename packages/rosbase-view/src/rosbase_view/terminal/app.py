"""The view as an application of textual."""

from typing import ClassVar

from textual.app import App
from textual.binding import Binding, BindingType
from textual.driver import Driver

from rosbase import Clock
from rosbase_view.drawing.glyphs import UNICODE, Glyphs
from rosbase_view.known import Known
from rosbase_view.reports import Said
from rosbase_view.source import Change, Gaze, Source
from rosbase_view.terminal.main_screen import MainScreen
from rosbase_view.view import View

__all__ = ["ViewApp"]

_REDRAW_S = 0.1


class ViewApp(App[None]):
    """Takes reports of a source ten times a second, and shows what has changed."""

    TITLE = "rosbase view"
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("q", "quit", "Quit", show=False),
        # Of textual's own, which only tells of another key, and of a field's, which copies.
        Binding("ctrl+c", "quit", "Quit", show=False, priority=True),
    ]

    def __init__(
        self,
        source: Source,
        clock: Clock,
        glyphs: Glyphs = UNICODE,
        *,
        redraw_s: float | None = _REDRAW_S,
        driver_class: type[Driver] | None = None,
    ) -> None:
        """Show what a source reports.

        Args:
            source: Started when the terminal is ready, and closed at the end.
            clock: Tells the age of messages.
            glyphs: Characters that the terminal can show.
            redraw_s: Seconds between two redraws; None leaves `step` to the caller.
            driver_class: Reads and writes the terminal; None takes textual's own.
        """
        # The colours of the terminal, as the user has chosen them; none at all with NO_COLOR.
        super().__init__(driver_class, ansi_color=True)
        self.view = View(Known(), glyphs)
        self._source = source
        self._clock = clock
        self._redraw_s = redraw_s
        self._gaze = Gaze()

    def get_default_screen(self) -> MainScreen:
        """Return the only screen; textual calls it."""
        playback = self._source.playback
        self._main = MainScreen(self.view, self._clock.monotonic_ns, self._change, playback)
        return self._main

    def on_mount(self) -> None:
        """Begin to look."""
        self._source.start()
        if self._source.playback is not None:
            self._source.playback.play()
        if self._redraw_s is not None:
            self.set_interval(self._redraw_s, self.step)

    def on_unmount(self) -> None:
        """End looking."""
        self._source.close()

    def step(self) -> None:
        """Take what was reported, and show it."""
        self.view.known.take(self._source.take(), self._clock.monotonic_ns())
        gaze = self.view.gaze
        if gaze != self._gaze:
            self._gaze = gaze
            self.view.known.forget_unseen(gaze)
            self._source.look_at(gaze)
        self._main.redraw()

    def _change(self, change: Change) -> None:
        if self._source.can_change:
            self._source.change(change)
        else:
            said = Said("a recording cannot be changed", is_error=True)
            self.view.known.take([said], self._clock.monotonic_ns())
