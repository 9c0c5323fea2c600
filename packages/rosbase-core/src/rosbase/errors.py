"""Exceptions of rosbase, as a tree.

```
RosbaseError
├── ConfigurationError            a usage error; shown as one line, exit status 2
│   ├── ParameterError            baudrate:=fast, an unknown parameter
│   │   └── GivenParameterError   a wrong value from outside the program
│   ├── NotInstalledError         no such backend, transport or preset
│   ├── RecordingError            a file that exists already, a folder that does not
│   └── MappingError              a payload mapping that cannot be built
├── BackendError                  a topic used with two types, a closed backend
├── ServiceError                  a service call without an answer, such as a cancelled one
│   ├── ServiceTimeoutError       the service is absent, or too slow
│   ├── ServiceFailedError        the service raised an exception, or went away
│   ├── ServiceStoppedError       the program was asked to stop while the call waited
│   └── ServiceDepthError         calls within calls, without an end
├── TransportError                the device or the link
│   ├── DeviceNotFoundError       unplugged, or the wrong path
│   ├── DevicePermissionError     the user may not open it
│   ├── DeviceBusyError           another program holds it
│   └── NotADeviceError           a directory or a file; waiting will not help
├── TransitionNotAvailableError   the lifecycle state does not offer that transition
├── HandshakeTimeoutError         rules still pending when the time was up
├── ControlError                  a request to a running program without a result
├── WireError                     bytes that are no message of the type
└── PluginError                   a plugin that broke its promise
```
"""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable

__all__ = [
    "BackendError",
    "ConfigurationError",
    "ControlError",
    "DeviceBusyError",
    "DeviceNotFoundError",
    "DevicePermissionError",
    "GivenParameterError",
    "HandshakeTimeoutError",
    "MappingError",
    "NotADeviceError",
    "NotInstalledError",
    "ParameterError",
    "PluginError",
    "RecordingError",
    "RosbaseError",
    "ServiceDepthError",
    "ServiceError",
    "ServiceFailedError",
    "ServiceStoppedError",
    "ServiceTimeoutError",
    "TransitionNotAvailableError",
    "TransportError",
    "WireError",
]


class RosbaseError(Exception):
    """Root of the tree: catch it to catch everything that rosbase raises on purpose."""


class ConfigurationError(RosbaseError):
    """A request of the user cannot be carried out. The message is one line."""


class ParameterError(ConfigurationError):
    """A parameter is unknown, of the wrong type, or out of its range."""


class GivenParameterError(ParameterError):
    """A value from outside the program is not one of its parameter."""


class NotInstalledError(ConfigurationError):
    """A backend, transport or preset of that name is not installed."""


class RecordingError(ConfigurationError):
    """A recording cannot be made, or a file is none. The message names the file."""


class MappingError(ConfigurationError):
    """The description of a payload contradicts itself or lacks something."""


class BackendError(RosbaseError):
    """The backend refuses: it is closed, or a topic has another message type."""


class ServiceError(RosbaseError):
    """A service call has no answer. The message is one line: the service, and the cause."""


class ServiceTimeoutError(ServiceError):
    """The service is absent, or has not answered in time."""


class ServiceFailedError(ServiceError):
    """The service raised an exception, or went away before it answered.

    `reason` is the cause without the name of the service. If the service failed because it called
    another one, it is the cause there.
    """

    def __init__(self, service_name: str, reason: str = "it went away before it answered") -> None:
        super().__init__(f"{service_name} failed: {reason}")
        self.reason = reason


class ServiceStoppedError(ServiceError):
    """The program was asked to stop, which ends a call that waits.

    Let it pass: the program ends with status 0, after its clean-up.
    """


class ServiceDepthError(ServiceError):
    """As many calls wait within one another as may: services call each other in a circle."""


class TransportError(RosbaseError):
    """The device cannot be opened, or has been lost.

    `retryable` says whether a later try can help. `passes_soon` says whether the error usually
    passes within seconds, so that opening is tried for a few seconds.
    """

    retryable: bool = True
    passes_soon: bool = False


class DeviceNotFoundError(TransportError):
    """Nothing is there under that name: not plugged in yet, or misspelt."""


class DevicePermissionError(TransportError):
    """The device is there, and this user may not open it."""


class DeviceBusyError(TransportError):
    """Another program has the device open."""

    passes_soon = True


class NotADeviceError(TransportError):
    """The name leads to something that is not such a device."""

    retryable = False


class TransitionNotAvailableError(RosbaseError):
    """The lifecycle transition does not start at the current state. Nothing has changed."""


class HandshakeTimeoutError(RosbaseError):
    """Handshake rules did not come true in time; the message names them."""


class ControlError(RosbaseError):
    """A request to a running program has no result. The message is one line.

    `kind` is one of `unknown`, `ambiguous`, `refused`, `timeout`, `invalid` and `failed`.
    `suggestions` are names that may have been meant.
    """

    def __init__(self, text: str, kind: str = "failed", suggestions: Iterable[str] = ()) -> None:
        super().__init__(text)
        self.kind = kind
        self.suggestions = list(suggestions)


class WireError(RosbaseError):
    """Bytes are no message of that type: cut short, garbled, or of another type."""


class PluginError(RosbaseError):
    """A plugin registered something that the hook does not accept."""
