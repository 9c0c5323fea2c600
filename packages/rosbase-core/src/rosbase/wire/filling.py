"""Make a message of values that are right, without its constructor, which would check them."""

from collections.abc import Sequence

import attrs

from rosbase.wire.source import Source
from rosbase.wire.structure import Field, MessageType

__all__ = ["can_be_filled", "filled"]

_OUR_OWN = "rosbase.messages."


def can_be_filled(of: MessageType) -> bool:
    """Return whether a class is one of ours, whose slots are all there is to its instances."""
    return (
        of.cls.__module__.startswith(_OUR_OWN)
        and attrs.has(of.cls)
        and not hasattr(of.cls, "__attrs_post_init__")
        and all(hasattr(getattr(of.cls, one.name, None), "__set__") for one in of.fields)
    )


def filled(
    source: Source, of: MessageType, values: Sequence[tuple[Field, str]]
) -> tuple[str, list[str]]:
    """Return the variable of a message, and the lines that make it of the values.

    Args:
        source: The function that the lines are for.
        of: A class that can be filled.
        values: The expression of each field.
    """
    made, kind = source.new("made"), source.name_of(of.cls, "kind")
    lines = [f"{made} = {source.name_of(object.__new__, 'new')}({kind})"]
    for one, value in values:
        put = source.name_of(getattr(of.cls, one.name).__set__, "put")
        lines.append(f"{put}({made}, {value})")
    return made, lines
