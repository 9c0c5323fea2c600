"""Messages as bytes, without ROS: CDR, schemas, type hashes.

Everything is compiled or computed once for a message class, at its first use. Each function is
imported when it is used, because most programs need one or two of them.
"""

from typing import TYPE_CHECKING

from rosbase.messages.lazy import names_of, on_demand

if TYPE_CHECKING:
    from rosbase.wire.class_reader import deserialize, reader
    from rosbase.wire.class_writer import serialize, writer
    from rosbase.wire.description import describe
    from rosbase.wire.hashes import dds_type_name, type_hash
    from rosbase.wire.making import maker
    from rosbase.wire.packing import packer
    from rosbase.wire.schemas import schema
    from rosbase.wire.structure import MessageType
else:
    __getattr__ = on_demand(
        __name__,
        {
            "MessageType": "structure",
            "dds_type_name": "hashes",
            "describe": "description",
            "deserialize": "class_reader",
            "maker": "making",
            "packer": "packing",
            "reader": "class_reader",
            "schema": "schemas",
            "serialize": "class_writer",
            "type_hash": "hashes",
            "writer": "class_writer",
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
