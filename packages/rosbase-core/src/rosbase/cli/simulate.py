"""`rosbase simulate`: keep a simulated device running, for a reader in another terminal."""

import argparse
import shlex
from collections.abc import Callable
from typing import Any

from rosbase.cli.arguments import add_device_arguments, as_text, positive_number
from rosbase.cli.console import log_to_stderr
from rosbase.contracts.transport import PluggableDevice, SimulatedDevice
from rosbase.errors import ConfigurationError
from rosbase.imu.plugin_calls import simulate
from rosbase.imu.settings import DEFAULT_TRANSPORT
from rosbase.imu.simulated_faults import FAULTS
from rosbase.imu.simulator import ImuSimulator
from rosbase.manager import BaseManager
from rosbase.plugins import TransportPlugin, installed_plugins
from rosbase.roles.handlers import BaseHandlers

__all__ = ["configure", "run"]

_TICKS_HZ = 20.0
_UNPLUG = "unplug"
_UNPLUG_SUMMARY = "the plug is out for 2 s in every 10 s: the reader waits, and goes on"
_IN_S, _OUT_S = 8.0, 2.0


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    summaries = {**{name: kind.summary for name, kind in FAULTS.items()}, _UNPLUG: _UNPLUG_SUMMARY}
    parser.epilog = "faults:\n" + "\n".join(
        f"  {name:8} {summary}" for name, summary in summaries.items()
    )
    add_device_arguments(parser, 10_000.0)
    parser.add_argument(
        "--fault",
        choices=list(summaries),
        metavar="FAULT",
        help="simulate this fault of the device",
    )
    parser.add_argument(
        "--duration", type=positive_number, metavar="S", help="end after this many seconds"
    )


def run(arguments: argparse.Namespace) -> int:
    """Send samples until it is stopped."""
    log_to_stderr()
    transport = installed_plugins().transport(arguments.transport)
    device = simulate(transport)
    kind = FAULTS.get(arguments.fault)
    simulator = ImuSimulator(
        device, arguments.rate, fault=kind.make() if kind else None, is_attended=False
    )
    try:
        plug = _plug(device, transport) if arguments.fault == _UNPLUG else None
        print(f"A simulated IMU sends {arguments.rate:g} samples a second. Ctrl-C ends it.")
        print(f"Read it in another terminal:\n\n  {command_for(transport, device)}\n", flush=True)
        BaseManager(
            "simulate",
            handlers_class=_Handlers,
            node_freq_hz=_TICKS_HZ,
            backend="local",
            simulator=simulator,
            plug=plug,
            duration_s=arguments.duration,
        ).start_main_loop_timer()
    finally:
        simulator.stop()
        device.close()
    print(f"sent {simulator.sent}")
    return 0


def command_for(transport: TransportPlugin, device: SimulatedDevice) -> str:
    """Return the command that reads the device."""
    given = dict(device.parameters)
    if transport.name != DEFAULT_TRANSPORT:
        given = {"transport": transport.name, **given}
    words = [f"-p {shlex.quote(f'{name}:={as_text(value)}')}" for name, value in given.items()]
    return " ".join(["rosbase imu", *words])


def _plug(device: SimulatedDevice, transport: TransportPlugin) -> PluggableDevice:
    if not isinstance(device, PluggableDevice):
        raise ConfigurationError(
            f"the simulated device of transport '{transport.name}' has no plug to pull"
        )
    return device


class _Handlers(BaseHandlers):
    """Start the device, pull its plug on request, and end the run in time."""

    def __init__(
        self,
        manager: Any = None,
        *args: Any,
        simulator: ImuSimulator,
        plug: PluggableDevice | None,
        duration_s: float | None,
        **kwargs: Any,
    ) -> None:
        super().__init__(manager, *args, **kwargs)
        self._monotonic_ns: Callable[[], int] = manager.backend.clock.monotonic_ns
        self._simulator, self._plug, self._duration_s = simulator, plug, duration_s
        self._start_ns = self._monotonic_ns()
        self._is_in = True
        simulator.start()

    def handle(self) -> None:
        elapsed_s = (self._monotonic_ns() - self._start_ns) / 1e9
        if self._plug is not None:
            self._move(self._plug, elapsed_s % (_IN_S + _OUT_S) < _IN_S)
        if self._duration_s is not None and elapsed_s >= self._duration_s:
            self.manager.request_stop()

    def _move(self, plug: PluggableDevice, should_be_in: bool) -> None:
        if should_be_in == self._is_in:
            return
        self._is_in = should_be_in
        if should_be_in:
            plug.replug()
            self._simulator.start()
            self.logger.info("plugged in")
        else:
            self._simulator.stop()
            plug.unplug()
            self.logger.info("unplugged")
