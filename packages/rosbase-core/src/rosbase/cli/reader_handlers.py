"""The handlers of a run of the reader: they show its state and end it."""

from typing import TYPE_CHECKING, Any

from rosbase.cli.panel.drawing import LEAST_HEIGHT, LEAST_WIDTH, Panel
from rosbase.cli.panel.fields import Field, row
from rosbase.cli.panel.style import style_of
from rosbase.cli.report import count_fields, note_on, status_line, view_of
from rosbase.roles.handlers import BaseHandlers
from rosbase.text.printable import log_line, one_line

if TYPE_CHECKING:
    from rosbase.cli.session import ReaderManager

__all__ = ["ReaderHandlers"]

_MOST_DEVICE = 200
_STRANDED = "the reader did not become active"
_NOTHING = "nothing was published"
_ADVICE = "`rosbase doctor`, with the same -p, says what to do"
_WAITS = "wait_for_"


class ReaderHandlers(BaseHandlers):
    """Show the state of a run, and end it when its time is up."""

    manager: "ReaderManager"

    def __init__(
        self, manager: Any = None, *args: Any, duration_s: float | None = None, **kwargs: Any
    ) -> None:
        """Take the duration, after which the run ends, in seconds of the main loop."""
        super().__init__(manager, *args, **kwargs)
        self._monotonic_ns = manager.backend.clock.monotonic_ns
        self._duration_s = duration_s
        self._start_ns: int | None = None
        self._shown_ns = 0
        self._published = 0
        self._panel = Panel(style_of(manager.screen.encoding))
        self.elapsed_s = 0.0
        """Seconds that the main loop has run."""

    def handle(self) -> None:
        """Run one step. Called once per tick."""
        now_ns = self._monotonic_ns()
        if self._start_ns is None:
            self._start_ns = self._shown_ns = now_ns
        self.elapsed_s = (now_ns - self._start_ns) / 1e9
        self.manager.flush()
        if self.manager.is_active:
            self.manager.note_active()
        elif self.manager.is_stranded:
            self.manager.fail(f"{_STRANDED}. {_ADVICE}{self._waiting()}", has_run=False)
            return
        is_due = now_ns - self._shown_ns >= self.manager.screen.period_s * 1e9
        if is_due and not self.manager.is_quiet:
            self._show(now_ns)
        if self._duration_s is not None and self.elapsed_s >= self._duration_s:
            self.end_in_time(self._duration_s)

    def end_in_time(self, duration_s: float) -> None:
        """End the run. Called once per tick when the time of the run is up."""
        if self.manager.is_to_be_active and not self.manager.reader.counts.published:
            self.manager.fail(f"{_NOTHING}. {_ADVICE}")
        else:
            self.manager.request_stop()

    def _waiting(self) -> str:
        """Return the parameter that makes the transport wait for its device, if it has one."""
        specs = self.manager.reader.settings.transport.parameters
        names = [spec.name for spec in specs if spec.name.startswith(_WAITS)]
        return "".join(
            f"; -p {name}:=true waits for a {name.removeprefix(_WAITS)} that comes later"
            for name in names[:1]
        )

    def _show(self, now_ns: int) -> None:
        published = self.manager.reader.counts.published
        rate_hz = (published - self._published) * 1e9 / (now_ns - self._shown_ns)
        self._published, self._shown_ns = published, now_ns
        self.manager.screen.show(self._lines(rate_hz))

    def _lines(self, rate_hz: float) -> list[str]:
        manager = self.manager
        reader, last = manager.reader, manager.monitor.last if manager.monitor else None
        if not manager.screen.is_terminal:
            return [log_line(status_line(reader, last, manager.dropped, rate_hz))]
        width, height = manager.screen.size
        counts = self.counts(rate_hz)
        if width + 1 < LEAST_WIDTH or height < LEAST_HEIGHT:
            return [row([Field("", note_on(reader)[0]), *counts], width, self._panel.style)]
        return self._panel.draw(view_of(reader, last, self.title, counts, self.note), width)

    @property
    def title(self) -> list[Field]:
        """First line of the panel."""
        lasts = f"{self.elapsed_s:.1f} s"
        if self._duration_s is not None:
            lasts += f" of {self._duration_s:g} s"
        name, device = self.manager.name_of_run, self.manager.reader.settings.device
        return [Field(name), Field("", lasts), Field("", one_line(device, _MOST_DEVICE))]

    @property
    def note(self) -> tuple[str, str]:
        """Last line of the panel, and its colour; empty for the health of the reader."""
        return "", ""

    def counts(self, rate_hz: float) -> list[Field]:
        """Return the second line of the panel."""
        manager = self.manager
        return count_fields(manager.reader, rate_hz, manager.latency, ("dropped", manager.dropped))
