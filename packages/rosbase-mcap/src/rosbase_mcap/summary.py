"""The summary at the end of a file: what is in it, and where. Pure.

Readers need it to open a file quickly, and most open none without it.
"""

import struct
from collections import Counter
from collections.abc import Mapping
from zlib import crc32

from attrs import frozen

from rosbase_mcap.chunks import MessageTimes
from rosbase_mcap.records import (
    MAGIC,
    PREFIX,
    AttachmentIndex,
    Channel,
    ChunkIndex,
    Footer,
    Kind,
    MetadataIndex,
    Schema,
    Statistics,
    record,
)

__all__ = ["Snapshot", "Summary"]


@frozen
class Snapshot:
    """Contents of a file at some time: enough to go back to it."""

    lengths: tuple[int, int, int]
    """Number of chunks, attachments and records of metadata."""
    counts: Mapping[int, int]
    span_ns: tuple[int | None, int | None]


class Summary:
    """Contents of a file so far."""

    def __init__(self) -> None:
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.chunks: list[ChunkIndex] = []
        self.attachments: list[AttachmentIndex] = []
        self.metadata: list[MetadataIndex] = []
        self.counts: Counter[int] = Counter()
        """Number of messages by channel."""
        self.start_ns: int | None = None
        """Earliest `log_ns` of all messages; None without any."""
        self.end_ns: int | None = None
        """Latest `log_ns` of all messages; None without any."""

    def snapshot(self) -> Snapshot:
        """Return what is in the file now."""
        lengths = len(self.chunks), len(self.attachments), len(self.metadata)
        return Snapshot(lengths, dict(self.counts), (self.start_ns, self.end_ns))

    def go_back(self, to: Snapshot) -> None:
        """Forget what came later. Channels stay: one without messages does no harm."""
        chunks, attachments, metadata = to.lengths
        del self.chunks[chunks:], self.attachments[attachments:], self.metadata[metadata:]
        self.counts = Counter(to.counts)
        self.start_ns, self.end_ns = to.span_ns

    @property
    def messages(self) -> int:
        """Number of messages."""
        return sum(self.counts.values())

    def count(self, times: MessageTimes) -> None:
        """Count the messages of a chunk."""
        for channel, ones in times.items():
            self.counts[channel] += len(ones) // 2
            stamps = ones[::2]
            low, high = min(stamps), max(stamps)
            self.start_ns = low if self.start_ns is None else min(self.start_ns, low)
            self.end_ns = high if self.end_ns is None else max(self.end_ns, high)

    @property
    def statistics(self) -> Statistics:
        """The numbers of the file."""
        return Statistics(
            self.messages,
            len(self.schemas),
            len(self.channels),
            len(self.attachments),
            len(self.metadata),
            len(self.chunks),
            self.start_ns or 0,
            self.end_ns or 0,
            dict(self.counts),
        )

    def ending(self, at: int) -> bytes:
        """Return the end of a file whose data ends there.

        Args:
            at: Where these bytes will be in the file.
        """
        # The checksum of the data may be missing: each chunk has its own.
        data_end = record(Kind.DATA_END, struct.pack("<I", 0))
        start = at + len(data_end)
        body, offsets = b"", b""
        for kind, contents in self._groups():
            group = b"".join(record(kind, content) for content in contents)
            if group:
                place = struct.pack("<BQQ", kind, start + len(body), len(group))
                offsets += record(Kind.SUMMARY_OFFSET, place)
                body += group
        offsets_at = start + len(body)
        open_footer = PREFIX.pack(Kind.FOOTER, 20) + struct.pack("<QQ", start, offsets_at)
        checksum = crc32(body + offsets + open_footer)
        footer = record(Kind.FOOTER, Footer(start, offsets_at, checksum).content())
        return data_end + body + offsets + footer + MAGIC

    def _groups(self) -> list[tuple[Kind, list[bytes]]]:
        return [
            (Kind.SCHEMA, [one.content() for one in self.schemas.values()]),
            (Kind.CHANNEL, [one.content() for one in self.channels.values()]),
            (Kind.STATISTICS, [self.statistics.content()]),
            (Kind.CHUNK_INDEX, [one.content() for one in self.chunks]),
            (Kind.ATTACHMENT_INDEX, [one.content() for one in self.attachments]),
            (Kind.METADATA_INDEX, [one.content() for one in self.metadata]),
        ]
