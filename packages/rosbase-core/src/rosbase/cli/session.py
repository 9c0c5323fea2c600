"""A run of the reader by a command: the manager, and what it says at its end."""

import sys
from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

from rosbase.cli.console import LogOutput
from rosbase.cli.monitor import SampleMonitor
from rosbase.cli.output import Output
from rosbase.cli.panel.fields import wrapped
from rosbase.cli.reader_handlers import ReaderHandlers
from rosbase.cli.report import summary_lines
from rosbase.cli.screen import Screen
from rosbase.contracts.backend import BackendOptions
from rosbase.imu.reader import DEFAULT_NODE_NAME, ImuReader
from rosbase.lifecycle import State
from rosbase.manager import BaseManager
from rosbase.parameters import ParameterValue
from rosbase.roles.connection import open_backend
from rosbase.roles.node import BaseNode
from rosbase.runtime.histogram import Histogram
from rosbase.text.printable import log_line

__all__ = ["ReaderManager", "run_to_end"]

_TICKS_HZ = 20.0

# How long a reader that has stopped reading holds up the end.
_LAST_WRITE_S = 0.5

Echo: TypeAlias = Callable[[str], object]


class ReaderManager(BaseManager):
    """The reader on any backend, and a monitor of what it publishes where one is needed."""

    name_of_run = "rosbase imu"
    _has_run = True
    failure = ""
    """Why the run has failed, in one line; empty if it has not."""

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
        self._report = self._log if echoes else self._stdout
        self._echoes = echoes
        self.is_quiet = is_quiet
        self.screen = Screen(self._report)
        """Where the run is shown."""
        log.screen = self.screen
        opened = open_backend(backend, BackendOptions(DEFAULT_NODE_NAME, parameters))
        self._is_alone = opened.delivers_in_process and not is_quiet
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
        self.screen.end()
        if self._has_run and not self.is_quiet:
            self._report.write("".join(f"{self._fitted(line)}\n" for line in self.summary()))
        for output in (self._stdout, self._log):
            output.drain(_LAST_WRITE_S, self.backend.clock)
        if self._stdout.error:
            self.failure = f"cannot write: {self._stdout.error}"

    def _fitted(self, line: str) -> str:
        line = log_line(line)
        return wrapped(line, self.screen.size[0]) if self.screen.is_terminal else line

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

    def summary(self) -> list[str]:
        """The lines at the end of the run."""
        return list(summary_lines(self.reader, self.dropped, self.latency))

    @property
    def latency(self) -> Histogram | None:
        """From the stamp of a sample to the monitor, in nanoseconds; None if that says nothing.

        A device's own stamp says nothing, because its clock is not ours.
        """
        if self.monitor is None or self.reader.settings.uses_device_time:
            return None
        return self.monitor.latency

    @property
    def is_stranded(self) -> bool:
        """Whether the reader was to be active and is not, and nobody else could make it so."""
        return self._is_alone and self.is_to_be_active and not self.is_active

    @property
    def is_to_be_active(self) -> bool:
        """Whether the reader was to be brought up to the state active."""
        return self.reader.autostart == "activate"

    def fail(self, why: str, *, has_run: bool = True) -> None:
        """Ends the run, and has the command say why it has failed; without counts, if need be."""
        self.failure = why
        self._has_run = has_run
        self.request_stop()

    @property
    def is_active(self) -> bool:
        """Whether the reader is at work."""
        return self.reader.get_state() is State.ACTIVE

    def _print_sample(self, line: str) -> None:
        self._stdout.write(f"{line}\n")


def run_to_end(manager: ReaderManager) -> int:
    """Runs it; 0, or 1 with a line on stderr that says what has failed."""
    manager.start_main_loop_timer()
    if failure := manager.failure:
        print(f"rosbase: {failure}", file=sys.stderr)
        return 1
    return 0
