"""The schema text of a message in the format `ros2msg`, as in recordings of MCAP."""

from collections.abc import Iterator
from typing import Any

from rosbase.wire.description import Field, Kind, MessageType, describe

__all__ = ["schema", "schema_of"]

_RULE = "=" * 80


def schema(cls: type, *, with_defaults: bool = False) -> str:
    """Return the definition of a message class, followed by the messages within.

    Args:
        cls: The class.
        with_defaults: Whether fields have their defaults, as in a `.msg` file.

    Raises:
        TypeError: It is no message.
    """
    return schema_of(describe(cls), with_defaults=with_defaults)


def schema_of(own: MessageType, *, with_defaults: bool = False) -> str:
    """Return the definition of a message type; see `schema`."""
    texts = ["".join(_lines(own, with_defaults))]
    for part in own.parts():
        lines = "".join(_lines(part, with_defaults))
        texts.append(f"{_RULE}\nMSG: {_short(part)}\n{lines}")
    return "".join(texts)


def _lines(of: MessageType, with_defaults: bool) -> Iterator[str]:
    for constant in of.constants:
        yield f"{constant.width.value} {constant.name}={_value(constant.value)}\n"
    for one in of.fields:
        has_default = with_defaults and one.default is not None
        default = f" {_default(one.default)}" if has_default else ""
        yield f"{_type(one)} {one.name}{default}\n"


def _value(value: object) -> object:
    if not isinstance(value, str):
        return value
    # In one line, and without the end of the text within; ROS knows no other escapes.
    escaped = value.replace('"', r"\"").replace("\n", r"\n").replace("\r", r"\r")
    return f'"{escaped}"'


def _default(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_default, value))}]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + str.replace(value, "\\", "\\\\").replace('"', '\\"') + '"'
    # `repr` of the plain number: an enumeration's member would give its name.
    return repr(float(value) if isinstance(value, float) else int(value))


def _type(of: Field) -> str:
    text = _short(of.element) if isinstance(of.element, MessageType) else of.element.value
    if of.text_limit:
        text += f"<={of.text_limit}"
    if of.kind is Kind.ARRAY:
        return f"{text}[{of.size}]"
    if of.kind is Kind.SEQUENCE:
        return f"{text}[<={of.size}]" if of.size else f"{text}[]"
    return text


def _short(of: MessageType) -> str:
    package, kind, name = of.name.split("/")
    # Messages of services and actions keep their kind, as they would clash otherwise.
    return f"{package}/{name}" if kind == "msg" else of.name
