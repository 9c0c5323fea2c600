"""A run of the reader in a terminal: the manager, what it shows, and when it ends."""

import sys
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rosbase.cli.console import LiveLine, LogOutput
from rosbase.cli.monitor import SampleMonitor
from rosbase.cli.output import Output
from rosbase.cli.report import status_line, summary_lines
from rosbase.contracts.backend import BackendOptions
from rosbase.imu.reader import DEFAULT_NODE_NAME, ImuReader
from rosbase.lifecycle import State
from rosbase.manager import BaseManager
from rosbase.parameters import ParameterValue
from rosbase.roles.connection import open_backend
from rosbase.roles.handlers import BaseHandlers
from rosbase.roles.node import BaseNode
from rosbase.runtime.histogram import Histogram
from rosbase.text.printable import log_line

__all__ = ["ReaderHandlers", "ReaderManager", "run_to_end"]

_TICKS_HZ = 20.0

# How long a reader that has stopped reading holds up the end.
_LAST_WRITE_S = 0.5

Echo: TypeAlias = Callable[[str], object]


class ReaderHandlers(BaseHandlers):
    """Shows the live line, and ends the run when its time is up."""

    manager: "ReaderManager"

    def __init__(
        self, manager: Any = None, *args: Any, duration_s: float | None = None, **kwargs: Any
    ) -> None:
        """With a duration, the run ends after so many seconds of the main loop."""
        super().__init__(manager, *args, **kwargs)
        self._monotonic_ns = manager.backend.clock.monotonic_ns
        self._duration_s = duration_s
        self._start_ns: int | None = None
        self._shown_ns = 0
        self._published = 0

    def handle(self) -> None:
        """Called once per tick."""
        now_ns = self._monotonic_ns()
        if self._start_ns is None:
            self._start_ns = self._shown_ns = now_ns
        self.manager.flush()
        is_due = now_ns - self._shown_ns >= self.manager.live_line.period_s * 1e9
        if is_due and not self.manager.is_quiet:
            self._show(now_ns)
        if self._duration_s is not None and now_ns - self._start_ns >= self._duration_s * 1e9:
            self.manager.request_stop()

    def _show(self, now_ns: int) -> None:
        reader, monitor = self.manager.reader, self.manager.monitor
        last = monitor.last if monitor else None
        published = reader.counts.published
        rate_hz = (published - self._published) * 1e9 / (now_ns - self._shown_ns)
        self._published, self._shown_ns = published, now_ns
        self.manager.live_line.show(status_line(reader, last, self.manager.dropped, rate_hz))


class ReaderManager(BaseManager):
    """The reader on any backend, and a monitor of what it publishes where one is needed."""

    def __init__(
        self,
        parameters: Mapping[str, ParameterValue],
        log: LogOutput,
        *,
        backend: str | None = None,
        handlers_class: type[ReaderHandlers] = ReaderHandlers,
        echoes: bool = False,
        listens: bool = False,
        is_quiet: bool = False,
        **kwargs: Any,
    ) -> None:
        """Builds the run.

        Args:
            parameters: What the reader's parameters are set to.
            log: Where log records go; with `echoes`, everything but the samples.
            backend: Its name.
            handlers_class: What decides when the run ends.
            echoes: Whether stdout gets every sample, as a line of JSON.
            listens: Whether there is a monitor even if listening costs something.
            is_quiet: Whether nothing is shown but the log.
            kwargs: For the handlers, such as `duration_s`.
        """
        self._log = log
        self._stdout = Output(sys.stdout)
        self._report = log if echoes else self._stdout
        self._echoes = echoes
        self.is_quiet = is_quiet
        self.live_line = log.live_line = LiveLine(self._report)
        opened = open_backend(backend, BackendOptions(DEFAULT_NODE_NAME, parameters))
        nodes: dict[str, type[BaseNode]] = {DEFAULT_NODE_NAME: ImuReader}
        # For the live line, where listening costs little; where nothing is shown, for nobody.
        if echoes or listens or (opened.delivers_in_process and not is_quiet):
            nodes["monitor"] = SampleMonitor
        if echoes:
            # Only then: the monitor alone takes it, and a manager warns of what nobody takes.
            kwargs["echo"] = self._print_sample
        super().__init__(
            node_name=DEFAULT_NODE_NAME,
            nodes_dict=nodes,
            handlers_class=handlers_class,
            node_freq_hz=_TICKS_HZ,
            backend=opened,
            **kwargs,
        )

    @property
    def reader(self) -> ImuReader:
        """The reader."""
        reader: ImuReader = self.nodes[DEFAULT_NODE_NAME]
        return reader

    @property
    def monitor(self) -> SampleMonitor | None:
        """What listens to it, if anything does."""
        return self.nodes.get("monitor")

    def release_resources(self) -> None:
        """Hands over what was published last, and reports."""
        while self.backend.spin_once(0.0):
            pass
        if self._echoes:
            self._stdout.drain(_LAST_WRITE_S, self.backend.clock)
        self.live_line.end()
        if not self.is_quiet:
            self._report.write("".join(f"{log_line(line)}\n" for line in self.summary()))
        for output in (self._stdout, self._log):
            output.drain(_LAST_WRITE_S, self.backend.clock)

    def flush(self) -> None:
        """Writes what waits to be written; ends the run when nobody is left to read it."""
        self._log.flush()
        self._stdout.flush()
        if self._stdout.is_gone:
            self.request_stop()

    @property
    def dropped(self) -> int:
        """Samples that were published, and lost on the way to whoever wanted them."""
        lost_on_the_way = self.monitor.dropped if self.monitor else 0
        return lost_on_the_way + (self._stdout.dropped if self._echoes else 0)

    @property
    def output_error(self) -> str:
        """Why stdout could not be written, if it could not."""
        return self._stdout.error

    def summary(self) -> list[str]:
        """The lines at the end of the run."""
        stamps_arrival = not self.reader.settings.uses_device_time
        return self._summary(self.monitor.latency if self.monitor and stamps_arrival else None)

    def _summary(self, latency: Histogram | None) -> list[str]:
        return list(summary_lines(self.reader, self.dropped, latency))

    @property
    def is_active(self) -> bool:
        """Whether the reader is at work."""
        return self.reader.get_state() is State.ACTIVE

    def _print_sample(self, line: str) -> None:
        self._stdout.write(f"{line}\n")


def run_to_end(manager: ReaderManager) -> int:
    """Runs it; 0, or 1 with a line on stderr if what it had to say could not be written."""
    manager.start_main_loop_timer()
    if manager.output_error:
        print(f"rosbase: cannot write: {manager.output_error}", file=sys.stderr)
        return 1
    return 0
