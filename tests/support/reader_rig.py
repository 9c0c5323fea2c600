"""A reader with a transport that the test plays, in virtual time."""

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, cast

from rosbase.contracts.backend import BackendOptions
from rosbase.imu.reader import ImuReader
from rosbase.lifecycle import CallbackReturn
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Imu, MagneticField
from rosbase.plugins import installed_plugins
from rosbase.testing import ManualClock, ScriptedTransport
from support.transports import ScriptedRegistry

if TYPE_CHECKING:
    # `typing` has it from Python 3.11 on.
    from typing_extensions import Self

__all__ = ["Rig"]


class Rig:
    """A reader, its transport, and everything that it publishes."""

    def __init__(self, failure: Any = None, **parameters: Any) -> None:
        self.clock = ManualClock()
        self.registry = ScriptedRegistry(installed_plugins(), failure=failure)
        overrides = {"comm_t": "scripted", **parameters}
        self.backend = LocalBackend(
            BackendOptions("lifecycle_manager", overrides, self.clock), Bus()
        )
        self.reader = ImuReader(backend=self.backend, registry=cast("Any", self.registry))
        self.published: list[tuple[str, Any]] = []
        for name, kind in (("data", Imu), ("data_raw", Imu), ("mag", MagneticField)):
            self.backend.create_subscription(kind, f"imu/{name}", self._keep(name), 1000)

    def _keep(self, name: str) -> Callable[[Any], None]:
        return lambda message: self.published.append((name, message))

    @property
    def transport(self) -> ScriptedTransport:
        return self.registry.made[-1]

    def activate(self) -> "Self":
        assert self.reader.trigger_configure() is CallbackReturn.SUCCESS
        assert self.reader.trigger_activate() is CallbackReturn.SUCCESS
        return self

    def send(self, data: bytes | dict[str, Any], stamp_ns: int = 7) -> list[tuple[str, Any]]:
        """What one frame makes the reader publish."""
        self.transport.deliver(
            data if isinstance(data, bytes) else json.dumps(data).encode(), stamp_ns
        )
        self.published.clear()
        while self.backend.spin_once(0.0):
            pass
        return list(self.published)

    def pass_time(self, seconds: float) -> None:
        end_ns = self.clock.elapsed_ns + round(seconds * 1e9)
        self.backend.spin_until(end_ns, lambda: False)
        while self.backend.spin_once(0.0):
            pass
