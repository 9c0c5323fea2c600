"""The messages of a file as tables of text, a file for each topic."""

import csv
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any, BinaryIO

from rosbase.wire.plain import decoder
from rosbase_mcap.channel_table import CDR, ROS2MSG
from rosbase_mcap.errors import McapError
from rosbase_mcap.reading import Entry, Selection, messages

__all__ = ["columns", "export_csv"]

_STAMP = "log_time_ns"


def export_csv(stream: BinaryIO, folder: Path, selection: Selection) -> dict[Path, int]:
    """Write a table for each topic; return the number of rows of each.

    A field has a column, such as `angular_velocity.x`. A list is one cell, as JSON, because its
    length may differ from message to message.

    Raises:
        NotMcapError: The file does not begin as an MCAP file does.
        McapError: The messages of a topic are not CDR with a schema of ROS 2.
        FileExistsError: There is a file of such a name.
    """
    rows: dict[Path, int] = {}
    with ExitStack() as stack:
        tables: dict[int, _Table] = {}
        for entry in messages(stream, selection):
            table = tables.get(entry.channel.id)
            if table is None:
                path = _free_path(folder, entry.channel.topic, rows)
                table = tables[entry.channel.id] = _Table(path, entry, stack)
                rows[path] = 0
            table.add(entry)
            rows[table.path] += 1
    return rows


def columns(message: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, object]]:
    """Yield the name and the value of each cell of a message."""
    for name, value in message.items():
        if isinstance(value, Mapping):
            yield from columns(value, f"{prefix}{name}.")
        elif isinstance(value, (tuple, list, memoryview, bytes)):
            yield f"{prefix}{name}", json.dumps(list(value), default=list)
        else:
            yield f"{prefix}{name}", value


class _Table:
    """The file of one topic."""

    def __init__(self, path: Path, first: Entry, stack: ExitStack) -> None:
        self.path = path
        self._decode = _decoder(first)
        file = stack.enter_context(path.open("x", encoding="utf-8", newline=""))
        self._writer = csv.writer(file)
        names = [name for name, _ in columns(self._decode(first.message.data))]
        self._writer.writerow([_STAMP, *names])

    def add(self, entry: Entry) -> None:
        """Write a row."""
        cells = [value for _, value in columns(self._decode(entry.message.data))]
        self._writer.writerow([entry.message.log_ns, *cells])


def _decoder(entry: Entry) -> Callable[[bytes], dict[str, Any]]:
    channel, schema = entry.channel, entry.schema
    if schema is None or (channel.message_encoding, schema.encoding) != (CDR, ROS2MSG):
        raise McapError(f"{channel.topic}: only messages of ROS 2 can be exported")
    return decoder(schema.name, str(schema.data, "utf-8", "replace"))


def _free_path(folder: Path, topic: str, taken: Mapping[Path, object]) -> Path:
    name = topic.strip("/").replace("/", ".") or "topic"
    path, number = folder / f"{name}.csv", 1
    while path in taken:
        path, number = folder / f"{name}_{number}.csv", number + 1
    return path
