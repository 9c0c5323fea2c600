"""What a plugin can bring. A hook yields these; the registry keeps them by name."""

import argparse
from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar, TypeAlias

from attrs import Attribute, field, frozen, validators

from rosbase import messages
from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.checks import CheckContext, Finding
from rosbase.contracts.transport import SimulatedDevice, Transport, TransportContext
from rosbase.parameters import ParameterSpec, ParameterValue

__all__ = [
    "BackendPlugin",
    "CheckPlugin",
    "CommandPlugin",
    "ConversionPlugin",
    "Descriptor",
    "PresetPlugin",
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
    """What it is, in half a line."""
    create: Callable[[BackendOptions], Backend] = field(validator=validators.is_callable())
    """Opens one."""
    arguments_after: str = field(default="", validator=validators.instance_of(str))
    """After this word on a command line stand arguments of its own, such as `--ros-args`."""


@frozen
class TransportPlugin:
    """A transport that can be chosen by name, as `comm_t`."""

    kind: ClassVar[str] = "transport"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """What it is, in half a line."""
    create: Callable[[Mapping[str, ParameterValue], TransportContext], Transport] = field(
        validator=validators.is_callable()
    )
    """Makes one from the values of its parameters. Touches no device yet."""
    parameters: tuple[ParameterSpec, ...] = field(
        default=(),
        validator=validators.deep_iterable(
            validators.instance_of(ParameterSpec), validators.instance_of(tuple)
        ),
    )
    """The parameters it adds to a reader's. The first says which device it is."""
    simulate: Callable[[], SimulatedDevice] | None = None
    """Opens a stand-in for a device, if there is one."""
    hints: Mapping[str, str] = field(
        default={},  # shown in the documentation; nobody writes to it
        validator=validators.deep_mapping(validators.instance_of(str), validators.instance_of(str)),
    )
    """What the link may have to do with frames that are refused, by the reason that is counted."""


@frozen
class PresetPlugin:
    """The payload of a known device, as values for the `mapping.*` parameters."""

    kind: ClassVar[str] = "preset"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """Which device or firmware, in half a line."""
    values: Mapping[str, ParameterValue] = field(
        validator=validators.deep_mapping(
            validators.instance_of(str), validators.instance_of((bool, int, float, str, list))
        )
    )
    """By parameter name without the leading `mapping.`, such as `select`."""


@frozen
class CommandPlugin:
    """A subcommand of `rosbase`."""

    kind: ClassVar[str] = "command"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """What it does, in half a line."""
    configure: Callable[[argparse.ArgumentParser], object] = field(
        validator=validators.is_callable()
    )
    """Adds its arguments to its parser."""
    run: Callable[[Any], int] = field(validator=validators.is_callable())
    """Runs it with the parsed arguments; gives the exit status."""


def _of_ones_own(instance: object, attribute: "Attribute[type]", value: type) -> None:
    if value.__module__ == messages.__name__:
        raise ValueError(f"{value.__name__} is a message of rosbase, which every backend knows")


@frozen
class ConversionPlugin:
    """How a backend sends and receives messages of a class that it does not know."""

    kind: ClassVar[str] = "conversion"

    msg_type: type = field(validator=[validators.instance_of(type), _of_ones_own])
    """What programs publish and receive."""
    backend: str = field(validator=_word)
    """The name of the backend that it is for."""
    summary: str = field(validator=validators.instance_of(str))
    """What becomes of it there, in half a line."""
    create: Callable[[], Any] = field(validator=validators.is_callable())
    """Gives what that backend takes for it, as its documentation says. Called when a topic with
    such messages is first used there."""

    @property
    def name(self) -> str:
        """Whose it is: there is one for each class and backend."""
        return conversion_name(self.msg_type, self.backend)


def conversion_name(msg_type: type, backend: str) -> str:
    """What the conversion of messages of a class is called, on a backend."""
    return f"{msg_type.__module__}.{msg_type.__qualname__} on {backend}"


@frozen
class CheckPlugin:
    """A check of `rosbase doctor`."""

    kind: ClassVar[str] = "check"

    name: str = field(validator=_word)
    summary: str = field(validator=validators.instance_of(str))
    """What is looked at, in half a line."""
    run: Callable[[CheckContext], Iterable[Finding]] = field(validator=validators.is_callable())
    """Looks, on a thread of its own; `contracts/checks.py` says what it may do. Only here is
    imported what it needs."""


Descriptor: TypeAlias = (
    BackendPlugin | TransportPlugin | PresetPlugin | CommandPlugin | ConversionPlugin | CheckPlugin
)
"""Any of the classes that a hook yields."""
