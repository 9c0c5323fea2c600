"""Elements of viser's panel: set what has changed."""

from typing import Any

__all__ = ["update"]


def update(handle: Any, **values: Any) -> None:
    """Set the properties of an element that have changed: viser sends each that is set."""
    for name, value in values.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)
