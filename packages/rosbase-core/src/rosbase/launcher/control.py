"""The launcher as other commands see it: `rosbase ps`, `stop NAME` and `restart NAME`."""

from collections.abc import Iterator
from contextlib import contextmanager

from rosbase.launcher.description import Description
from rosbase.launcher.run import Run

__all__ = ["control_of"]


@contextmanager
def control_of(run: Run, description: Description) -> Iterator[None]:
    """Let other commands see and drive a run, as long as the context lasts."""
    yield
