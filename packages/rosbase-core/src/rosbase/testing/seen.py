"""What was seen of an author's code, in words that say where to look."""

import traceback
from pathlib import Path

__all__ = ["not_written", "raised"]


def not_written(name: str, error: NotImplementedError) -> str:
    """Of what raises NotImplementedError, with what that says to do."""
    return f"{name} is not written yet" + (f": {error}" if str(error) else "")


def raised(name: str, error: BaseException) -> str:
    """Of what raised something else, with the place where it did."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f", in {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
    return f"{name} raised {error!r}{place}"
