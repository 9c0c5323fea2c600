"""`rosbase demo`: run the reader on a simulated device at the far end of a real link."""

import argparse
from collections import deque
from typing import Any

from rosbase.cli.arguments import add_device_arguments, positive_number
from rosbase.cli.console import LogOutput, add_log_level, log_to_stderr
from rosbase.cli.counts_help import COUNTS_HELP
from rosbase.cli.panel.fields import Field
from rosbase.cli.plug import PlugPull
from rosbase.cli.reader_handlers import ReaderHandlers
from rosbase.cli.report import count_fields, summary_lines
from rosbase.cli.session import ReaderManager, run_to_end
from rosbase.contracts.transport import PluggableDevice
from rosbase.imu.plugin_calls import simulate
from rosbase.imu.simulator import ImuSimulator
from rosbase.parameters import ParameterValue
from rosbase.plugins import installed_plugins
from rosbase.runtime.histogram import Histogram

__all__ = ["configure", "run"]

_DRAIN_S = 2.0
_SHOWN_PER_S = 5
# The plug is pulled at this part of the run, and is out for a fifth of the run, a second at most.
_PULL_AT = 0.4
_OUT_PART, _MOST_OUT_S = 0.2, 1.0
# A device that does not come back holds up the end for so long.
_RETURN_S = 10.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = COUNTS_HELP
    add_device_arguments(parser, 100_000.0)
    parser.add_argument(
        "--duration", type=positive_number, default=10.0, metavar="S", help="seconds to run (10)"
    )
    parser.add_argument(
        "--no-unplug", action="store_true", help="leave the simulated device plugged in"
    )
    add_log_level(parser)


def run(arguments: argparse.Namespace) -> int:
    """Run the demo; return 0 if every sample that was sent has been published."""
    log = log_to_stderr(arguments.log_level)
    log.wraps = True
    transport = installed_plugins().transport(arguments.transport)
    device = simulate(transport)
    simulator = ImuSimulator(device, arguments.rate)
    can_unplug = isinstance(device, PluggableDevice) and not arguments.no_unplug
    try:
        manager = DemoManager(
            {
                **device.parameters,
                "comm_t": transport.name,
                "autostart": "activate",
                # The simulated device knows the time, so latency counts from its sending.
                "time_source": "device",
            },
            log,
            simulator=simulator,
            pluggable=device if can_unplug else None,
            handlers_class=DemoHandlers,
            duration_s=arguments.duration,
        )
        status = run_to_end(manager)
    finally:
        simulator.stop()
        device.close()
    return status or int(manager.has_lost_some)


class DemoHandlers(ReaderHandlers):
    """Starts the simulated device once the reader is active, and stops it before the reader."""

    manager: "DemoManager"

    def __init__(
        self,
        manager: Any = None,
        *args: Any,
        simulator: ImuSimulator,
        pluggable: PluggableDevice | None,
        duration_s: float,
        **kwargs: Any,
    ) -> None:
        """Take the simulator, and the plug of the device if it has one."""
        super().__init__(manager, *args, duration_s=duration_s, **kwargs)
        self._simulator = simulator
        self._sent_before = deque([0] * _SHOWN_PER_S, _SHOWN_PER_S)
        self._is_sending = False
        self._ended_s: float | None = None
        if pluggable is not None:
            manager.pull = PlugPull(
                pluggable,
                simulator,
                manager.reader,
                at_s=_PULL_AT * duration_s,
                out_s=min(_OUT_PART * duration_s, _MOST_OUT_S),
            )

    def handle(self) -> None:
        """Run one step. Called once per tick."""
        if not (self._is_sending or self.manager.is_ending):
            if not self.manager.is_active:
                self.manager.request_stop()
            else:
                self._simulator.start()
                self._is_sending = True
        super().handle()
        pull = self.manager.pull
        if pull is not None and not self.manager.is_ending:
            pull.step(self.elapsed_s)
        if self.manager.is_ending:
            self._finish()

    def end_in_time(self, duration_s: float) -> None:
        """End the run, but wait for a device that is about to come back."""
        pull = self.manager.pull
        if pull is None or not pull.is_busy or self.elapsed_s > duration_s + _RETURN_S:
            super().end_in_time(duration_s)

    @property
    def note(self) -> tuple[str, str]:
        """State of the plug, once it has changed."""
        return self.manager.pull.note if self.manager.pull else ("", "")

    def counts(self, rate_hz: float) -> list[Field]:
        """Return the second line of the panel."""
        manager, sent = self.manager, self._simulator.sent
        # What was sent a second ago has had the time to arrive.
        lost = max(0, self._sent_before[0] - manager.reader.counts.received)
        self._sent_before.append(sent)
        return count_fields(manager.reader, rate_hz, manager.latency, ("lost", lost), sent)

    def _finish(self) -> None:
        """Stop the device, and the reader once it has read everything."""
        if self._ended_s is None:
            self._simulator.stop()
            self._ended_s = self.elapsed_s
        has_all = self.manager.reader.counts.received >= self._simulator.sent
        if has_all or self.elapsed_s - self._ended_s > _DRAIN_S:
            self.manager.finish()


class DemoManager(ReaderManager):
    """A run in which the device finishes first after a request to stop, so that nothing is lost."""

    name_of_run = "rosbase demo"
    is_ending = False

    def __init__(
        self,
        parameters: dict[str, ParameterValue],
        log: LogOutput,
        *,
        simulator: ImuSimulator,
        **kwargs: Any,
    ) -> None:
        """Build the run."""
        self._simulator = simulator
        self.pull: PlugPull | None = None
        """Pulls the plug, if the device has one."""
        super().__init__(parameters, log, simulator=simulator, listens=True, **kwargs)

    def request_stop(self) -> None:
        """Ask the handlers to end the run in good order."""
        self.is_ending = True

    def finish(self) -> None:
        """End the main loop."""
        super().request_stop()

    @property
    def latency(self) -> Histogram | None:
        """Latency from the stamp of a sample to the monitor: the simulated device has our clock."""
        return self.monitor.latency if self.monitor else None

    @property
    def has_lost_some(self) -> bool:
        """Whether fewer samples were published than sent, or none was sent."""
        return not 0 < self._simulator.sent == self.reader.counts.published

    def summary(self) -> list[str]:
        """Return the verdict, the counts, the numbers sent and lost, and the next command."""
        sent = self._simulator.sent
        lost = sent - self.reader.counts.received
        counts = summary_lines(self.reader, self.dropped, self.latency)
        return [
            self._verdict(sent),
            f"sent {sent}",
            f"lost {lost}",
            *counts,
            "Try next: rosbase simulate (runs a simulated device for you to read)",
        ]

    def _verdict(self, sent: int) -> str:
        published = self.reader.counts.published
        if not sent:
            return "Nothing was sent: the reader did not become active."
        if self.has_lost_some:
            return f"Only {published} of {sent} samples were published."
        all_of_them = f"All {sent} samples that the device sent were published"
        if self.pull is None:
            return f"{all_of_them}."
        if self.pull.was_out_s is None:
            return f"{all_of_them}; the device was not plugged in again before the end."
        return f"{all_of_them}, although it was unplugged for {self.pull.was_out_s:.1f} s."
