"""Descriptors of a plugin's parts. A hook yields them; the registry keeps them by name."""

import argparse
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, TypeAlias

from attrs import Attribute, field, frozen, validators

from rosbase import messages
from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.checks import CheckContext, Finding
from rosbase.contracts.message_format import MessageFormat
from rosbase.contracts.recording import Recording, RecordOptions
from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.parameters import ParameterSpec, ParameterValue

__all__ = [
    "BackendPlugin",
    "CheckPlugin",
    "CommandPlugin",
    "ConversionPlugin",
    "Descriptor",
    "PresetPlugin",
    "RecorderPlugin",
    "TransportPlugin",
]


def _word(instance: object, attribute: "Attribute[str]", value: object) -> None:
    text = value if isinstance(value, str) else ""
    if not text.replace("-", "_").isidentifier():
        raise ValueError(f"{attribute.name} must be one word, not {value!r}")


@frozen
class BackendPlugin:
    """A backend that can be chosen by name."""

    kind: ClassVar[str] = "backend"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """Description in half a line."""
    create: Callable[[BackendOptions], Backend] = field(validator=validators.is_callable())
    """Opens a backend."""
    arguments_after: str = field(default="", validator=validators.instance_of(str))
    """Word on a command line, such as `--ros-args`, that begins the backend's own arguments."""
    message_format: Callable[[Any], MessageFormat] | None = None
    """Returns the format of a class of messages that only this backend knows, for a replay, which
    does not open it. TypeError for other classes."""


@frozen
class TransportPlugin:
    """A transport that can be chosen by name, as `comm_t`."""

    kind: ClassVar[str] = "transport"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """Description in half a line."""
    create: Callable[[Mapping[str, ParameterValue], TransportContext], Transport] = field(
        validator=validators.is_callable()
    )
    """Makes a transport from the values of its parameters. Touches no device yet."""
    parameters: tuple[ParameterSpec, ...] = field(
        default=(),
        validator=validators.deep_iterable(
            validators.instance_of(ParameterSpec), validators.instance_of(tuple)
        ),
    )
    """Parameters that it adds to a reader's. The first one selects the device."""
    simulate: Callable[[], SimulatedDevice] | None = None
    """Opens a simulated device, if there is one."""
    hints: Mapping[str, str] = field(
        default={},  # shown in the documentation; nobody writes to it
        validator=validators.deep_mapping(validators.instance_of(str), validators.instance_of(str)),
    )
    """Hints on causes in the link for refused frames, by the reason that is counted."""


@frozen
class PresetPlugin:
    """The payload of a known device, as values for the `mapping.*` parameters."""

    kind: ClassVar[str] = "preset"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """Device or firmware, in half a line."""
    values: Mapping[str, ParameterValue] = field(
        validator=validators.deep_mapping(
            validators.instance_of(str), validators.instance_of((bool, int, float, str, list))
        )
    )
    """Values by parameter name without the leading `mapping.`, such as `select`."""


@frozen
class CommandPlugin:
    """A subcommand of `rosbase`."""

    kind: ClassVar[str] = "command"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """Description in half a line."""
    configure: Callable[[argparse.ArgumentParser], object] = field(
        validator=validators.is_callable()
    )
    """Adds its arguments to its parser."""
    run: Callable[[Any], int] = field(validator=validators.is_callable())
    """Runs the command with the parsed arguments; returns the exit status."""
    forwards_backend_arguments: bool = field(default=False, kw_only=True)
    """Whether arguments for a backend, such as those after `--ros-args`, and everything after `--`
    are for a program that it runs. It finds them in `backend_arguments` of the parsed arguments."""


def _of_ones_own(instance: object, attribute: "Attribute[type]", value: type) -> None:
    if f"{value.__module__}.".startswith(f"{messages.__name__}."):
        raise ValueError(f"{value.__name__} is a message of rosbase, which every backend knows")


@frozen
class ConversionPlugin:
    """Conversion of a message class for a backend that does not know the class."""

    kind: ClassVar[str] = "conversion"

    msg_type: type = field(validator=[validators.instance_of(type), _of_ones_own])
    """Message class that programs publish and receive."""
    backend: str = field(validator=_word)
    """Name of the backend."""
    summary: str = field(validator=validators.instance_of(str))
    """Description of the result, in half a line."""
    create: Callable[[], Any] = field(validator=validators.is_callable())
    """Returns the backend's object for the class, as the backend's documentation says.

    Called when a topic with such messages is first used there.
    """

    @property
    def name(self) -> str:
        """Name of the conversion: there is one for each class and backend."""
        return conversion_name(self.msg_type, self.backend)


def conversion_name(msg_type: type, backend: str) -> str:
    """Return the name of the conversion for a message class on a backend."""
    return f"{msg_type.__module__}.{msg_type.__qualname__} on {backend}"


@frozen
class CheckPlugin:
    """A check of `rosbase doctor`."""

    kind: ClassVar[str] = "check"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """Description of the check, in half a line."""
    run: Callable[[CheckContext], Iterable[Finding]] = field(validator=validators.is_callable())
    """Runs the check, on its own thread; `contracts/checks.py` has the rules.

    Import dependencies only here.
    """


@frozen
class RecorderPlugin:
    """A recorder of programs: one kind of files."""

    kind: ClassVar[str] = "recorder"

    name: str = field(validator=_word)
    """The suffix of its files, such as `mcap`."""
    summary: str = field(validator=validators.instance_of(str))
    """Description in half a line."""
    open: Callable[[RecordOptions], Recording] = field(validator=validators.is_callable())
    """Creates the file, and returns a recording that has not begun.

    It raises a RecordingError if it cannot, and never overwrites a file.
    """


Descriptor: TypeAlias = (
    BackendPlugin
    | TransportPlugin
    | PresetPlugin
    | CommandPlugin
    | ConversionPlugin
    | CheckPlugin
    | RecorderPlugin
)
"""Any of the classes that a hook yields."""
