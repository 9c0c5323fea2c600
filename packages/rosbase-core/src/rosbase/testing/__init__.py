"""Helpers for the tests of programs and plugins. No other module of rosbase imports it.

The contracts need pytest and hypothesis, which the extra `rosbase-core[testing]` installs; the rest
does not. So each name is imported when it is first used. The strategies for hypothesis are in
`rosbase.testing.strategies`.
"""

from typing import TYPE_CHECKING

from rosbase.messages.lazy import names_of, on_demand

if TYPE_CHECKING:
    from rosbase.testing.backend import virtual_backend
    from rosbase.testing.backend_contract import (
        BackendCapabilities,
        BackendContract,
        ServiceKind,
    )
    from rosbase.testing.clock import ManualClock
    from rosbase.testing.faults import Faults
    from rosbase.testing.framer_contract import FramerContract
    from rosbase.testing.promise import BrokenPromiseError, Promise
    from rosbase.testing.recorded_log import RecordedLog
    from rosbase.testing.recording import Received, RecordingSubscriber
    from rosbase.testing.scripted_transport import ScriptedTransport
    from rosbase.testing.transport_contract import TransportContract
    from rosbase.testing.transport_kit.capabilities import FullPeer, TransportCapabilities
else:
    __getattr__ = on_demand(
        __name__,
        {
            "BackendCapabilities": "backend_contract",
            "BackendContract": "backend_contract",
            "BrokenPromiseError": "promise",
            "Faults": "faults",
            "FramerContract": "framer_contract",
            "FullPeer": "transport_kit.capabilities",
            "ManualClock": "clock",
            "Promise": "promise",
            "Received": "recording",
            "RecordedLog": "recorded_log",
            "RecordingSubscriber": "recording",
            "ScriptedTransport": "scripted_transport",
            "ServiceKind": "backend_contract",
            "TransportCapabilities": "transport_kit.capabilities",
            "TransportContract": "transport_contract",
            "virtual_backend": "backend",
        },
        __name__,
    )

__all__ = [
    "BackendCapabilities",
    "BackendContract",
    "BrokenPromiseError",
    "Faults",
    "FramerContract",
    "FullPeer",
    "ManualClock",
    "Promise",
    "Received",
    "RecordedLog",
    "RecordingSubscriber",
    "ScriptedTransport",
    "ServiceKind",
    "TransportCapabilities",
    "TransportContract",
    "virtual_backend",
]

__dir__ = names_of(__all__)
