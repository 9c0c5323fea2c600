"""A file on a disk that may become full, or be pulled out."""

import os
from pathlib import Path

__all__ = ["OutputFile"]


class OutputFile:
    """Writes each piece as a whole: what a full disk leaves of one is cut off again."""

    def __init__(self, path: Path) -> None:
        """Create the file.

        Raises:
            FileExistsError: There is one of that name; a recording is never overwritten.
            OSError: It cannot be created.
        """
        self.path = path
        # Without a buffer, so that SIGKILL loses nothing that was written.
        self._file = path.open("xb", buffering=0)
        self.size_bytes = 0
        """Length of the pieces that were written as a whole."""

    @property
    def is_closed(self) -> bool:
        """Whether it takes nothing more."""
        return self._file.closed

    def write(self, data: bytes | memoryview) -> None:
        """Write all of the bytes.

        Raises:
            OSError: The disk takes no more.
        """
        left = memoryview(data)
        while left:
            left = left[self._file.write(left) :]
        self.size_bytes += len(data)

    def sync(self) -> None:
        """Wait until the disk has what was written, so that a loss of power loses none of it.

        Raises:
            OSError: The disk has not taken it.
        """
        os.fdatasync(self._file.fileno())

    def cut(self, size_bytes: int | None = None) -> None:
        """Cut off what is left of a piece that was not written as a whole.

        Args:
            size_bytes: Cut whole pieces off too, down to this length.

        Raises:
            OSError: The disk is gone.
        """
        self.size_bytes = self.size_bytes if size_bytes is None else size_bytes
        self._file.truncate(self.size_bytes)
        self._file.seek(self.size_bytes)

    def close(self) -> None:
        """Close the file. May be called repeatedly.

        Raises:
            OSError: The disk is gone.
        """
        self._file.close()
