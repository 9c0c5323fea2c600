"""`rosbase demo`: runs the reader on a simulated device at the far end of a real link."""

import argparse
from typing import Any

from rosbase.cli.arguments import number_between, positive_number
from rosbase.cli.console import LogOutput, add_log_level, log_to_stderr
from rosbase.cli.session import ReaderHandlers, ReaderManager, run_to_end
from rosbase.imu.plugin_calls import simulate
from rosbase.imu.simulator import ImuSimulator
from rosbase.parameters import ParameterValue
from rosbase.plugins import installed_plugins

__all__ = ["configure", "run"]

_DRAIN_S = 2.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments."""
    parser.add_argument(
        "--rate",
        type=number_between(0.01, 100_000.0),
        default=100.0,
        metavar="HZ",
        help="samples per second (100)",
    )
    parser.add_argument(
        "--duration", type=positive_number, default=10.0, metavar="S", help="seconds to run (10)"
    )
    parser.add_argument("--transport", default="serial", metavar="NAME", help="the link (serial)")
    add_log_level(parser)


def run(arguments: argparse.Namespace) -> int:
    """Runs the demo; 0 if every sample that was sent has been published."""
    log = log_to_stderr(arguments.log_level)
    transport = installed_plugins().transport(arguments.transport)
    device = simulate(transport)
    simulator = ImuSimulator(device, arguments.rate)
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
            handlers_class=DemoHandlers,
            duration_s=arguments.duration,
        )
        status = run_to_end(manager)
    finally:
        simulator.stop()
        device.close()
    lost_some = not 0 < simulator.sent == manager.reader.counts.published
    return status or int(lost_some)


class DemoHandlers(ReaderHandlers):
    """Starts the simulated device once the reader is active, and ends it before the reader."""

    manager: "DemoManager"

    def __init__(
        self, manager: Any = None, *args: Any, simulator: ImuSimulator, **kwargs: Any
    ) -> None:
        """Takes charge of the simulator."""
        super().__init__(manager, *args, **kwargs)
        self._simulator = simulator
        self._is_sending = False
        self._ended_ns: int | None = None

    def handle(self) -> None:
        """Called once per tick."""
        if not (self._is_sending or self.manager.is_ending):
            if not self.manager.is_active:
                self.manager.request_stop()
            else:
                self._simulator.start()
                self._is_sending = True
        super().handle()
        if self.manager.is_ending:
            self._finish()

    def _finish(self) -> None:
        """Stops the device, and the reader once it has read everything."""
        if self._ended_ns is None:
            self._simulator.stop()
            self._ended_ns = self._monotonic_ns()
        waited_ns = self._monotonic_ns() - self._ended_ns
        has_all = self.manager.reader.counts.received >= self._simulator.sent
        if has_all or waited_ns > _DRAIN_S * 1e9:
            self.manager.finish()


class DemoManager(ReaderManager):
    """A run that is asked to stop lets the device finish first, so that nothing is lost."""

    is_ending = False

    def __init__(
        self,
        parameters: dict[str, ParameterValue],
        log: LogOutput,
        *,
        simulator: ImuSimulator,
        **kwargs: Any,
    ) -> None:
        """Builds the run."""
        self._simulator = simulator
        super().__init__(parameters, log, simulator=simulator, listens=True, **kwargs)

    def request_stop(self) -> None:
        """Has the handlers end the run in good order."""
        self.is_ending = True

    def finish(self) -> None:
        """Ends the main loop."""
        super().request_stop()

    def summary(self) -> list[str]:
        """The lines at the end of the run, and how many were sent and lost."""
        sent = self._simulator.sent
        lost = sent - self.reader.counts.received
        # The simulated device stamps what it sends, so its time counts.
        latency = self.monitor.latency if self.monitor else None
        return [f"sent {sent}", f"lost {lost}", *self._summary(latency)]
