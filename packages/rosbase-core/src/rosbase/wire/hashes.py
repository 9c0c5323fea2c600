"""The type hash of ROS 2 (REP-2016): SHA-256 over the description of a type in JSON."""

import hashlib
import json
from typing import Any

from rosbase.messages.fields import Width
from rosbase.wire.description import Field, Kind, MessageType, describe
from rosbase.wire.once import once_per_class

__all__ = ["dds_type_name", "hash_of", "type_hash"]

# type_description_interfaces/msg/FieldType, for one element.
_NESTED, _STRING, _WSTRING, _BOUNDED_STRING, _BOUNDED_WSTRING = 1, 17, 18, 21, 22
_IDS = {
    Width.INT8: 2,
    Width.UINT8: 3,
    Width.INT16: 4,
    Width.UINT16: 5,
    Width.INT32: 6,
    Width.UINT32: 7,
    Width.INT64: 8,
    Width.UINT64: 9,
    Width.FLOAT32: 10,
    Width.FLOAT64: 11,
    # rosidl turns a char of a .msg file into uint8.
    Width.CHAR: 3,
    Width.BOOL: 15,
    Width.BYTE: 16,
    Width.STRING: _STRING,
    Width.WSTRING: _WSTRING,
}
_ARRAY, _BOUNDED_SEQUENCE, _SEQUENCE = 48, 96, 144
# What stands in for no field at all: C and DDS have no empty structures.
_PLACEHOLDER = "structure_needs_at_least_one_member"


@once_per_class
def type_hash(cls: type) -> str:
    """Return the hash of a message class, such as `RIHS01_7d9a00ff...`.

    Raises:
        TypeError: It is no message.
    """
    return hash_of(describe(cls))


def hash_of(own: MessageType) -> str:
    """Return the hash of a message type."""
    parts = sorted(own.parts(), key=lambda part: part.name)
    described = {
        "type_description": _described(own),
        "referenced_type_descriptions": [_described(part) for part in parts],
    }
    text = json.dumps(described, ensure_ascii=True, separators=(", ", ": "))
    return f"RIHS01_{hashlib.sha256(text.encode()).hexdigest()}"


def dds_type_name(cls: type) -> str:
    """Return the name under which DDS knows a message class: `sensor_msgs::msg::dds_::Imu_`.

    Raises:
        TypeError: It is no message.
    """
    package, kind, name = describe(cls).name.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def _described(of: MessageType) -> dict[str, Any]:
    fields = [{"name": one.name, "type": _field_type(one)} for one in of.fields]
    if not fields:
        fields = [{"name": _PLACEHOLDER, "type": _typed(3, 0, 0, "")}]
    return {"type_name": of.name, "fields": fields}


def _field_type(of: Field) -> dict[str, Any]:
    if isinstance(of.element, MessageType):
        number, nested = _NESTED, of.element.name
    else:
        number, nested = _IDS[of.element], ""
        if of.text_limit:
            number = _BOUNDED_STRING if of.element is Width.STRING else _BOUNDED_WSTRING
    if of.kind is Kind.ARRAY:
        number += _ARRAY
    elif of.kind is Kind.SEQUENCE:
        number += _BOUNDED_SEQUENCE if of.size else _SEQUENCE
    return _typed(number, of.size, of.text_limit, nested)


def _typed(number: int, capacity: int, text_limit: int, nested: str) -> dict[str, Any]:
    return {
        "type_id": number,
        "capacity": capacity,
        "string_capacity": text_limit,
        "nested_type_name": nested,
    }
