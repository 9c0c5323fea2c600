"""A run of the reader by a command: the manager, and its report at the end."""

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
    """The reader on any backend, and a monitor of its topics if one is needed."""

    name_of_run = "rosbase imu"
    _has_run = True
    failure = ""
    """Reason of a failure of the run, in one line; empty if there is none."""

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
        """Build the run.

        Args:
            parameters: Values of the reader's parameters.
            log: Output of log records; with `echoes`, of everything but the samples.
            backend: Name of the backend.
            handlers_class: Class that decides when the run ends.
            echoes: Whether to print every sample to stdout, as a line of JSON.
            listens: Whether to create a monitor even if listening costs something.
            is_quiet: Whether to show nothing but the log.
            kwargs: Arguments for the handlers, such as `duration_s`.
        """
        self._log = log
        self._stdout = Output(sys.stdout)
        self._report = self._log if echoes else self._stdout
        self._echoes = echoes
        self.is_quiet = is_quiet
        self.screen = Screen(self._report)
        """Screen that shows the run."""
        log.screen = self.screen
        opened = open_backend(backend, BackendOptions(DEFAULT_NODE_NAME, parameters))
        self._is_alone = opened.delivers_in_process and not is_quiet
        self._was_active = False
        self._error_before: BaseException | None = None
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
        """Reader of the run."""
        reader: ImuReader = self.nodes[DEFAULT_NODE_NAME]
        return reader

    @property
    def monitor(self) -> SampleMonitor | None:
        """Monitor of the reader's topics, if there is one."""
        return self.nodes.get("monitor")

    def release_resources(self) -> None:
        """Print the last messages, and report."""
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
        """Write waiting text; end the run when no reader of the output is left."""
        self._log.flush()
        self._stdout.flush()
        if self._stdout.is_gone:
            self.request_stop()

    @property
    def dropped(self) -> int:
        """Number of samples published, but lost on the way to the output or the monitor."""
        lost_on_the_way = self.monitor.dropped if self.monitor else 0
        return lost_on_the_way + (self._stdout.dropped if self._echoes else 0)

    def summary(self) -> list[str]:
        """Return the lines at the end of the run."""
        return list(summary_lines(self.reader, self.dropped, self.latency))

    @property
    def latency(self) -> Histogram | None:
        """Latency in nanoseconds from the stamp of a sample to the monitor; None if meaningless.

        It is meaningless for a device's own stamps, because its clock is not ours.
        """
        if self.monitor is None or self.reader.settings.uses_device_time:
            return None
        return self.monitor.latency

    @property
    def is_stranded(self) -> bool:
        """Whether the reader should be active, and has failed where nobody looks after it.

        A reader that was active, and that somebody deactivated with `rosbase lifecycle set`, has
        not failed.
        """
        if not (self._is_alone and self.is_to_be_active) or self.is_active:
            return False
        return not self._was_active or self.reader.last_error is not self._error_before

    def note_active(self) -> None:
        """Remember that the reader is active. Called once per tick in which it is."""
        self._was_active, self._error_before = True, self.reader.last_error

    @property
    def is_to_be_active(self) -> bool:
        """Whether the reader should be brought up to the state active."""
        return self.reader.autostart == "activate"

    def fail(self, why: str, *, has_run: bool = True) -> None:
        """End the run with a message why it has failed; without counts, if necessary."""
        self.failure = why
        self._has_run = has_run
        self.request_stop()

    @property
    def is_active(self) -> bool:
        """Whether the reader is active."""
        return self.reader.get_state() is State.ACTIVE

    def _print_sample(self, line: str) -> None:
        self._stdout.write(f"{line}\n")


def run_to_end(manager: ReaderManager) -> int:
    """Run to the end; return 0, or 1 with a line on stderr that gives the failure."""
    manager.start_main_loop_timer()
    if failure := manager.failure:
        print(f"rosbase: {failure}", file=sys.stderr)
        return 1
    return 0
