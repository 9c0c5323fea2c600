"""Descriptions of what a check saw, which say where to look."""

import traceback
from pathlib import Path

__all__ = ["not_written", "raised"]


def not_written(name: str, error: NotImplementedError) -> str:
    """Describe a call that raises NotImplementedError, with its message."""
    return f"{name} is not written yet" + (f": {error}" if str(error) else "")


def raised(name: str, error: BaseException) -> str:
    """Describe a call that raised another exception, with the place."""
    frames = traceback.extract_tb(error.__traceback__)
    place = f", in {Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else ""
    return f"{name} raised {error!r}{place}"
