"""Values of messages: as users type them, and as ROS prints calls of their classes."""

from __future__ import annotations

from rosbase.cli.operate.reading import UsageError
from rosbase.text.yaml_flow import read_flow

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from typing import Any

    from rosbase.wire.structure import MessageType

__all__ = ["as_call", "decoded", "encoded", "parsed", "read_values"]


def read_values(text: str | None) -> Mapping[str, Any]:
    """Return the fields in a text: YAML or JSON.

    Raises:
        UsageError: It is neither, or no fields.
    """
    if text is None:
        return {}
    try:
        values = _several_lines(text) if "\n" in text.strip() else read_flow(text)
    except ValueError as error:
        raise UsageError(f"the values are no YAML: {error}") from error
    # `ros2` takes the header of a message as `auto`, so a text within is not wrong.
    if values is None:
        return {}
    if not isinstance(values, dict):
        raise UsageError(f"the values are fields such as 'x: 1.5', not {text[:80]!r}")
    return values


def _several_lines(text: str) -> Any:
    try:
        import yaml
    except ImportError:
        raise UsageError(
            "values in several lines need PyYAML: pip install pyyaml; or write them in one line"
        ) from None
    try:
        # It leaves all scalars texts: the type of the field decides how to read them.
        return yaml.load(text, Loader=yaml.BaseLoader)
    except yaml.YAMLError as error:
        raise ValueError(" ".join(str(error).split())) from error


def encoded(encode: Callable[[Mapping[str, Any]], bytes], values: Mapping[str, Any]) -> bytes:
    """Return values as CDR.

    Raises:
        UsageError: They do not fit the type.
    """
    try:
        return encode(values)
    except (TypeError, ValueError, OverflowError) as error:
        raise UsageError(f"the values do not fit: {error}") from error


def parsed(of: Mapping[str, Any]) -> MessageType:
    """Return the type that an answer of a program describes."""
    from rosbase.wire.schema_text import parse_schema

    return parse_schema(of["type"], of["schema"])


def decoded(of: Mapping[str, Any], data: bytes) -> str:
    """Return a message, as CDR, as `as_call` writes it."""
    from rosbase.wire.plain import decoder

    return as_call(parsed(of), decoder(of["type"], of["schema"])(data))


def as_call(of: MessageType, values: Mapping[str, Any]) -> str:
    """Return a message as `ros2` prints it: `geometry_msgs.msg.Point(x=1.0, y=0.0, z=0.0)`."""
    parts = (f"{one.alias}={_field(one.element, values[one.alias])}" for one in of.fields)
    return f"{of.name.replace('/', '.')}({', '.join(parts)})"


def _field(element: Any, value: Any) -> str:
    if isinstance(value, dict):
        return as_call(element, value)
    if isinstance(value, memoryview):
        return repr(value.tolist())
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(_field(element, item) for item in value)}]"
    return repr(value)
