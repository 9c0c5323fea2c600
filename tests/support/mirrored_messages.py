"""Own message classes with the fields of a ROS message class, as a program would write them."""

import dataclasses
import functools
import re
from typing import Annotated, Any

from attrs import field, make_class

from rosbase.messages import fields
from rosbase.messages.fields import AtMost, Fixed, message
from support.ros_messages import ros_class

__all__ = ["mirrored"]

_NAMES = {"boolean": bool, "octet": fields.Byte, "float": fields.Float32, "double": float}
_TYPES: dict[str, Any] = {
    **_NAMES,
    "string": str,
    "wstring": fields.WString,
    **{f"int{bits}": getattr(fields, f"Int{bits}") for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": getattr(fields, f"UInt{bits}") for bits in (8, 16, 32, 64)},
}
_FORM = re.compile(
    r"(?P<sequence>sequence<)?(?P<element>[\w/]+)(?:<(?P<text>\d+)>)?"
    r"(?:, (?P<most>\d+)>|>)?(?:\[(?P<size>\d+)\])?"
)


@functools.cache
def mirrored(name: str, kind: str) -> Any:
    """Return a frozen class (`attrs` or `dataclass`) with the fields of the ROS class of a name."""
    own = name.rpartition("/")[2]
    types = {
        one: _annotation(text, kind)
        for one, text in ros_class(name).get_fields_and_field_types().items()
    }
    if kind == "dataclass":
        return message(name)(dataclasses.make_dataclass(own, types.items(), frozen=True))
    made = {one: field(type=annotation) for one, annotation in types.items()}
    return message(name)(make_class(own, made, frozen=True, slots=True))


def _annotation(text: str, kind: str) -> Any:
    match = _FORM.fullmatch(text)
    assert match, text
    element: Any
    if "/" in match["element"]:
        package, own = match["element"].split("/")
        element = mirrored(f"{package}/msg/{own}", kind)
    else:
        element = _TYPES[match["element"]]
    if match["text"]:
        element = Annotated[element, AtMost(int(match["text"]))]
    # Only a variable with a type of its own is no type for mypy.
    many: Any = tuple.__class_getitem__((element, ...))
    if match["size"]:
        return Annotated[many, Fixed(int(match["size"]))]
    if match["most"]:
        return Annotated[many, AtMost(int(match["most"]))]
    return many if match["sequence"] else element
