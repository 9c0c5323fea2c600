"""A message as the rows of a tree, some of which are folded."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, TypeAlias

from attrs import frozen

from rosbase_view.drawing.figures import number

__all__ = ["Path", "TreeRow", "tree_rows"]

Path: TypeAlias = tuple[str | int, ...]

_MOST_INLINE = 4
_MOST_NUMBERS = 9
_MOST_ITEMS = 20


@frozen
class TreeRow:
    """A field."""

    path: Path
    name: str
    value: str
    is_open: bool | None
    """Whether the rows below belong to it; None if it has none."""

    @property
    def depth(self) -> int:
        """Number of fields above it."""
        return len(self.path) - 1


def tree_rows(message: Mapping[str, Any], folded: Collection[Path] = ()) -> list[TreeRow]:
    """Return a row for each field, with the fields of an inner message below it.

    A few numbers together, such as a vector, are one row. Of a long list, the first items are
    shown, with its length.

    Args:
        message: Fields by name, as `rosbase.wire.plain` reads them.
        folded: Paths of fields whose own fields are left out.
    """
    return [row for name, value in message.items() for row in _rows((name,), value, folded)]


def _rows(path: Path, value: Any, folded: Collection[Path]) -> Iterator[TreeRow]:
    name = str(path[-1])
    items = _items(value)
    if items is None:
        yield TreeRow(path, name, _leaf(value), None)
        return
    is_open = path not in folded
    yield TreeRow(path, name, "" if isinstance(value, Mapping) else f"[{len(value)}]", is_open)
    if is_open:
        for key, one in items:
            yield from _rows((*path, key), one, folded)


def _items(value: Any) -> list[tuple[str | int, Any]] | None:
    """Return what is within a value; None if it is shown in one row."""
    if isinstance(value, Mapping):
        return None if _is_inline(value) else list(value.items())
    if isinstance(value, (tuple, list)) and any(isinstance(one, (Mapping, str)) for one in value):
        return list(enumerate(value[:_MOST_ITEMS]))
    return None


def _is_inline(value: Mapping[str, Any]) -> bool:
    return len(value) <= _MOST_INLINE and all(type(one) in (int, float) for one in value.values())


def _leaf(value: Any) -> str:
    if isinstance(value, Mapping):
        # There is room for a sign, so that nothing jumps, but not in whole numbers such as dates.
        texts = {name: number(one) for name, one in value.items()}
        if all(type(one) is int for one in value.values()):
            texts = {name: text.strip() for name, text in texts.items()}
        return "  ".join(f"{name} {text}" for name, text in texts.items())
    if isinstance(value, (bool, str)):
        return str(value)
    if isinstance(value, (int, float)):
        return number(value)
    if isinstance(value, (bytes, memoryview, Sequence)):
        return _numbers(value)
    return str(value)


def _numbers(values: Sequence[Any]) -> str:
    # A memoryview of numbers has them, and not their bytes.
    shown = [str(one) if isinstance(one, bool) else number(one) for one in values[:_MOST_NUMBERS]]
    more = f" ... [{len(values)}]" if len(values) > _MOST_NUMBERS else ""
    return f"[{','.join(shown)}{more}]" if shown else "[]"
