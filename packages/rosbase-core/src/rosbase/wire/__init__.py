"""Messages as bytes, without ROS: CDR, schemas, type hashes.

Everything is compiled or computed once for a message class, at its first use. Each function is
imported when it is used, because most programs need one or two of them.
"""

from typing import TYPE_CHECKING

from rosbase.messages.lazy import names_of, on_demand

if TYPE_CHECKING:
    from rosbase.wire.description import MessageType, describe
    from rosbase.wire.making import maker
    from rosbase.wire.packing import packer
    from rosbase.wire.reading import deserialize, reader
    from rosbase.wire.schema_text import schema
    from rosbase.wire.type_names import dds_type_name, type_hash
    from rosbase.wire.writing import serialize, writer
else:
    __getattr__ = on_demand(
        __name__,
        {
            "MessageType": "description",
            "dds_type_name": "type_names",
            "describe": "description",
            "deserialize": "reading",
            "maker": "making",
            "packer": "packing",
            "reader": "reading",
            "schema": "schema_text",
            "serialize": "writing",
            "type_hash": "type_names",
            "writer": "writing",
        },
        __name__,
    )

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

__dir__ = names_of(__all__)
