"""Compressed chunks. A library is imported only for a chunk that needs it."""

from zlib import crc32

from rosbase_mcap.errors import McapError
from rosbase_mcap.records import Chunk

__all__ = ["COMPRESSIONS", "MOST_CHUNK_BYTES", "compressed", "unpacked"]

COMPRESSIONS = ("", "lz4", "zstd")
"""The ways to compress a chunk; empty for none."""
MOST_CHUNK_BYTES = 1 << 30
"""Largest chunk that is read. A file may say anything, and a small one may unpack to much."""


def compressed(data: bytes | memoryview, compression: str) -> bytes | memoryview:
    """Return the records of a chunk as they are in the file.

    Raises:
        McapError: There is no such compression.
    """
    if not compression:
        return data
    if compression == "lz4":
        import lz4.frame

        packed: bytes = lz4.frame.compress(data)
        return packed
    if compression == "zstd":
        import zstandard

        return zstandard.compress(data)
    raise _unknown(compression)


def unpacked(chunk: Chunk) -> bytes | memoryview:
    """Return the records of a chunk, checked.

    Raises:
        McapError: The chunk is damaged, too large, or of an unknown compression.
    """
    if chunk.size_bytes > MOST_CHUNK_BYTES:
        raise McapError(f"a chunk of {chunk.size_bytes} bytes is too large")
    data = _unpacked(chunk)
    if len(data) != chunk.size_bytes:
        raise McapError(f"a chunk has {len(data)} bytes of records, not {chunk.size_bytes}")
    if chunk.crc and crc32(data) != chunk.crc:
        raise McapError("the checksum of a chunk is wrong")
    return data


def _unpacked(chunk: Chunk) -> bytes | memoryview:
    if not chunk.compression:
        return chunk.data
    if chunk.compression == "lz4":
        import lz4.frame

        try:
            # One byte more shows that there are too many.
            unpacker = lz4.frame.LZ4FrameDecompressor()
            found: bytes = unpacker.decompress(chunk.data, max_length=chunk.size_bytes + 1)
        except RuntimeError as error:
            raise McapError(f"a chunk is damaged: {error}") from error
        return found
    if chunk.compression == "zstd":
        import zstandard

        # Its frame may say a size of its own, for which the library would make room.
        reader = zstandard.ZstdDecompressor().stream_reader(chunk.data)
        try:
            return reader.read(chunk.size_bytes + 1)
        except zstandard.ZstdError as error:
            raise McapError(f"a chunk is damaged: {error}") from error
    raise _unknown(chunk.compression)


def _unknown(compression: str) -> McapError:
    known = ", ".join(filter(None, COMPRESSIONS))
    return McapError(f"unknown compression {compression!r}; there are: {known}")
