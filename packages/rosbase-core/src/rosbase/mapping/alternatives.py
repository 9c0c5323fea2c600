"""Read the first alternative of a quantity that is in a payload."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from attrs import evolve

from rosbase.mapping.quantities import Components

__all__ = ["compile_alternatives"]

FoundT = TypeVar("FoundT")


def compile_alternatives(
    alternatives: Sequence[Components],
    compile_one: Callable[[Components], Callable[[Any], FoundT]],
) -> Callable[[Any], FoundT]:
    """Return a reader of the first alternative that is in the payload.

    Args:
        alternatives: The components of each alternative.
        compile_one: Makes a reader of one, for payloads with one sample or with several.
    """
    readers = [compile_one(components) for components in alternatives]
    if len(readers) == 1:
        return readers[0]

    def read_first(payload: Any) -> FoundT:
        for read in readers[:-1]:
            found = read(payload)
            if found is not None:
                return found
        return readers[-1](payload)

    if not any(components.absent_is_zero for components in alternatives):
        return read_first
    values = [compile_one(evolve(components, has_object=False)) for components in alternatives]

    def read_value(payload: Any) -> FoundT:
        # One with a value goes before one with nothing but zeros that were left out.
        for value, read in zip(values, readers, strict=True):
            if _has_any(value(payload)):
                return read(payload)
        return read_first(payload)

    return read_value


def _has_any(found: object) -> bool:
    """Return whether anything of a quantity is there, in any sample."""
    return any(one is not None for one in found) if isinstance(found, list) else found is not None
