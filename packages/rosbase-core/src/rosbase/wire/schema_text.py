"""The schema text of a message in the format `ros2msg`, as in recordings of MCAP."""

from collections.abc import Iterator

from rosbase.wire.description import Field, Kind, MessageType, describe

__all__ = ["schema"]

_RULE = "=" * 80


def schema(cls: type) -> str:
    """Return the definition of a message class, followed by those of the messages within.

    Raises:
        TypeError: It is no message.
    """
    own = describe(cls)
    texts = ["".join(_lines(own))]
    for part in own.parts():
        texts.append(f"{_RULE}\nMSG: {_short(part)}\n" + "".join(_lines(part)))
    return "".join(texts)


def _lines(of: MessageType) -> Iterator[str]:
    for constant in of.constants:
        yield f"{constant.width.value} {constant.name}={_value(constant.value)}\n"
    for one in of.fields:
        yield f"{_type(one)} {one.name}\n"


def _value(value: object) -> object:
    if not isinstance(value, str):
        return value
    # In one line, and without the end of the text within; ROS knows no other escapes.
    escaped = value.replace('"', r"\"").replace("\n", r"\n").replace("\r", r"\r")
    return f'"{escaped}"'


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
