"""The values that a parameter file has for a node that runs."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rosbase.errors import ControlError, GivenParameterError
from rosbase.parameters import ParameterKind, ParameterSpec
from rosbase.parameters.given import GivenParameters
from rosbase.program.files import read_file

__all__ = ["values_in"]


def values_in(
    file: str,
    names: Sequence[str],
    managers: Sequence[str],
    types: Mapping[str, str],
    *,
    wildcards: bool,
) -> tuple[dict[str, Any], list[str]]:
    """Return the values of a node's parameters in a file, and a line for each unknown parameter.

    The types of the parameters decide how the values are read, as at the start of a program.

    Args:
        file: Path of the file.
        names: Names of the node, the one for messages first.
        managers: Names of its manager, if it shares the connection of one.
        types: Types of its parameters, by name.
        wildcards: Whether to take the values for every node too.

    Raises:
        ConfigurationError: The file cannot be read.
        ControlError: A value is not of the type of its parameter.
    """
    every = ("", "/**")
    given = [v for v in read_file(Path(file)) if wildcards or v.node not in every]
    values = GivenParameters(given)
    found: dict[str, Any] = {}
    for name, kind in types.items():
        spec = ParameterSpec(name, "", kind=ParameterKind[kind.upper()])
        try:
            value = values.value_for(spec, names, managers)
        except GivenParameterError as error:
            raise ControlError(str(error), "invalid") from error
        if value is not None:
            found[name] = _plain(value)
    return found, values.unused(only_for=names[0])


def _plain(value: Any) -> Any:
    """Return a value as JSON has it: bytes as whole numbers."""
    if isinstance(value, (list, tuple)):
        return [item[0] if isinstance(item, bytes) else item for item in value]
    return value
