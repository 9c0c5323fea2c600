"""Code that runs in the middle of other code, as a signal handler does."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

__all__ = ["coming_in"]

# Python runs signal handlers at the beginning of a function and behind a call.
_MOMENTS = ("call", "return", "c_return")


@contextmanager
def coming_in(
    run: Callable[[], object], *, behind: str | None = None, skipping: int = 0
) -> Iterator[None]:
    """Runs something once, at some moment of the code in this block.

    The moment is behind the next call of a function of C with the given name; without one, it is
    the next moment at all. As many such moments are skipped first as the caller says.
    """
    left = skipping

    def look(_frame: FrameType, event: str, function: Any) -> None:
        nonlocal left
        if event not in _MOMENTS or (behind and getattr(function, "__name__", "") != behind):
            return
        left -= 1
        if left < 0:
            sys.setprofile(None)
            run()

    sys.setprofile(look)
    try:
        yield
    finally:
        sys.setprofile(None)
