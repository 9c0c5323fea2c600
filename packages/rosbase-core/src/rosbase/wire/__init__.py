"""Messages as bytes, without ROS: CDR, schemas, type hashes.

Everything is compiled or computed once for a message class, at its first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rosbase.wire.class_reader import deserialize, reader
    from rosbase.wire.class_writer import serialize, writer
    from rosbase.wire.description import MessageType, describe
    from rosbase.wire.hashes import dds_type_name, type_hash
    from rosbase.wire.prepared import maker, packer
    from rosbase.wire.schemas import schema

__all__ = [
    "MessageType",
    "dds_type_name",
    "describe",
    "deserialize",
    "maker",
    "packer",
    "reader",
    "schema",
    "serialize",
    "type_hash",
    "writer",
]

# No module has the name of a function: once imported, it would hide it.
_HOMES = {
    "MessageType": "structure",
    "dds_type_name": "hashes",
    "describe": "description",
    "deserialize": "class_reader",
    "maker": "prepared",
    "packer": "prepared",
    "reader": "class_reader",
    "schema": "schemas",
    "serialize": "class_writer",
    "type_hash": "hashes",
    "writer": "class_writer",
}


def __getattr__(name: str) -> Any:
    """Import each name on first use: `plain` does without most of them."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return __all__
