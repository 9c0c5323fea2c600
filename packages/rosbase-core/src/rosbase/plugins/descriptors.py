"""What a plugin can bring. A hook yields these; the registry keeps them by name."""

import argparse
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, TypeAlias

from attrs import Attribute, field, frozen, validators

from rosbase.backend import Backend, BackendOptions
from rosbase.parameters import ParameterSpec, ParameterValue
from rosbase.transport import SimulatedDevice, Transport, TransportContext

__all__ = [
    "BackendPlugin",
    "CommandPlugin",
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
    """The parameters it adds to a reader's."""
    simulate: Callable[[], SimulatedDevice] | None = None
    """Opens a stand-in for a device, if there is one."""


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


Descriptor: TypeAlias = BackendPlugin | TransportPlugin | PresetPlugin | CommandPlugin
