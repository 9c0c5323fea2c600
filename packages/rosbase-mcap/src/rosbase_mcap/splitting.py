"""When a recording goes on in another file, and how that is called."""

from itertools import count
from pathlib import Path

from attrs import frozen

__all__ = ["Split", "free_part", "part_path"]


@frozen
class Split:
    """Limits of one file; 0 is none. They are looked at between two chunks."""

    bytes: int = 0
    """Length of a file."""
    duration_ns: int = 0
    """Time between the first message of a file and the last, in nanoseconds."""

    def is_due(self, size_bytes: int, duration_ns: int) -> bool:
        """Return whether a file of that length and time is full."""
        is_long = 0 < self.bytes <= size_bytes
        return is_long or 0 < self.duration_ns <= duration_ns


def part_path(path: Path, part: int) -> Path:
    """Return the name of a part: `run.mcap`, `run_1.mcap`, `run_2.mcap`."""
    return path if part == 0 else path.with_name(f"{path.stem}_{part}{path.suffix}")


def free_part(path: Path) -> Path:
    """Return the first of these names that no file has."""
    return next(part for part in (part_path(path, n) for n in count()) if not part.exists())
