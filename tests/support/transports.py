"""The scripted transport, as a plugin."""

from collections.abc import Callable, Mapping
from typing import Any

from rosbase.contracts.transport import TransportContext
from rosbase.errors import TransportError
from rosbase.parameters import ParameterSpec, ParameterValue
from rosbase.plugins import TransportPlugin
from rosbase.testing import ScriptedTransport

HINTS = {
    "not_utf8": "check the wire",
    "overlong": "is it the right wire?",
    "unended": "is it the right wire?",
}
"""What the scripted transport says of frames that are refused."""


class ScriptedRegistry:
    """The installed plugins, with the scripted transport in place of all others."""

    def __init__(self, registry: Any, *, failure: TransportError | None = None) -> None:
        self._registry = registry
        self.failure = failure
        self.create: Callable[[], Any] | None = None
        """Takes the place of what makes a transport."""
        self.made: list[ScriptedTransport] = []
        self._plugin = TransportPlugin(
            "scripted",
            "the test",
            self._create,
            parameters=(ParameterSpec("gain", 1.0, "a parameter of the transport"),),
            hints=HINTS,
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

    def _create(self, values: Mapping[str, ParameterValue], context: TransportContext) -> Any:
        if self.create is not None:
            return self.create()
        transport = ScriptedTransport(values, context)
        transport.failure = self.failure
        self.made.append(transport)
        return transport
