"""A transport whose device is the test."""

from collections.abc import Mapping
from typing import Any

from rosbase.errors import TransportError
from rosbase.parameters import ParameterSpec, ParameterValue
from rosbase.plugins import TransportPlugin
from rosbase.transport import (
    OnFrame,
    Transport,
    TransportContext,
    TransportHealth,
    TransportState,
)


class ScriptedTransport(Transport):
    """Hands over what the test gives it, on the test's thread, and notes the calls."""

    def __init__(self, values: Mapping[str, ParameterValue], context: TransportContext) -> None:
        self.values = values
        self.context = context
        self.calls: list[str] = []
        self.failure: TransportError | None = None
        self.frame_errors: dict[str, int] = {}
        self.state = TransportState.CLOSED
        self.last_data_ns: int | None = None
        self._on_frame: OnFrame | None = None

    def open(self) -> None:
        self.calls.append("open")
        if self.failure is not None:
            raise self.failure
        self.state = TransportState.CONNECTED

    def start(self, on_frame: OnFrame) -> None:
        self.calls.append("start")
        self._on_frame = on_frame

    def stop(self) -> None:
        self.calls.append("stop")
        self._on_frame = None

    def close(self) -> None:
        self.calls.append("close")
        self._on_frame = None
        self.state = TransportState.CLOSED

    @property
    def is_open(self) -> bool:
        return self.state is TransportState.CONNECTED

    @property
    def health(self) -> TransportHealth:
        return TransportHealth(
            state=self.state,
            frame_errors=self.frame_errors,
            last_data_ns=self.last_data_ns,
            last_error=str(self.failure or ""),
        )

    def deliver(self, frame: bytes, stamp_ns: int = 0) -> None:
        """One frame from the device."""
        assert self._on_frame is not None, "the reader has not been started"
        self.last_data_ns = self.context.clock.monotonic_ns()
        self._on_frame(frame, stamp_ns)


class ScriptedRegistry:
    """The installed plugins, with the scripted transport in place of all others."""

    def __init__(self, registry: Any, *, failure: TransportError | None = None) -> None:
        self._registry = registry
        self.failure = failure
        self.made: list[ScriptedTransport] = []
        self._plugin = TransportPlugin(
            "scripted",
            "the test",
            self._create,
            parameters=(ParameterSpec("gain", 1.0, "a parameter of the transport"),),
        )

    @property
    def transports(self) -> Mapping[str, TransportPlugin]:
        return {"scripted": self._plugin}

    def transport(self, name: str) -> TransportPlugin:
        return self._plugin if name == "scripted" else self._registry.transport(name)

    def is_ours(self, kind: str, name: str) -> bool:
        return False

    def preset(self, name: str) -> Any:
        return self._registry.preset(name)

    def _create(
        self, values: Mapping[str, ParameterValue], context: TransportContext
    ) -> ScriptedTransport:
        transport = ScriptedTransport(values, context)
        transport.failure = self.failure
        self.made.append(transport)
        return transport
