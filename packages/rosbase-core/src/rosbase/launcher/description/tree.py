"""A file of the launcher as a tree of values that know their lines, whatever the file's format."""

from collections.abc import Mapping
from typing import Any

from attrs import define, field, frozen

__all__ = ["Fault", "Faults", "Value", "as_tree"]


_DEEPEST = 32


@frozen
class Fault:
    """A mistake in a file."""

    file: str
    """The file as the user named it; empty for a description that is no file."""
    line: int
    """Line number from 1; 0 if it is unknown."""
    text: str

    def __str__(self) -> str:
        """Return `FILE:LINE: text`, as compilers write it."""
        place = ":".join(filter(None, [self.file, str(self.line or "")]))
        return f"{place}: {self.text}" if place else self.text


@define
class Faults:
    """All mistakes of a file that have been found so far."""

    file: str = ""
    _found: list[Fault] = field(init=False, factory=list)

    def add(self, line: int, text: str) -> None:
        """Note a mistake."""
        fault = Fault(self.file, line, text)
        if fault not in self._found:
            self._found.append(fault)

    def in_order(self) -> list[Fault]:
        """Return the mistakes in the order of the file."""
        return sorted(self._found, key=lambda fault: fault.line)


@frozen
class Value:
    """A value of the file. In a mapping, its line is the line of its key."""

    data: Any
    """A scalar, or a list of values, or a dict of values by name."""
    line: int
    text: str = ""
    """A scalar as it is written in the file."""

    @property
    def kind(self) -> str:
        """The kind of the value in a user's words."""
        if self.data is None:
            return "empty"
        names = {bool: "true or false", int: "a number", float: "a number", str: "a text"}
        names |= {list: "a list", dict: "a mapping"}
        return names.get(type(self.data), "something else")

    @property
    def is_scalar(self) -> bool:
        """Whether it is a single value that can be written as text."""
        return isinstance(self.data, (str, bool, int, float))


def as_tree(
    data: object, line: int = 0, lines: Mapping[tuple[Any, ...], int] | None = None
) -> Value:
    """Return the tree of data as a parser of TOML or JSON gives it.

    Args:
        data: The data.
        line: Line of the data itself.
        lines: Lines of what is within, by path; a path that is missing has the line around it.

    Raises:
        RecursionError: It is nested too deeply, as data that contains itself.
    """
    return _tree(data, (), line, lines or {})


def _tree(
    data: object, path: tuple[Any, ...], line: int, lines: Mapping[tuple[Any, ...], int]
) -> Value:
    line = lines.get(path, line)
    if len(path) > _DEEPEST:
        raise RecursionError("nested too deeply")
    if isinstance(data, Mapping):
        entries = {str(key): _tree(value, (*path, key), line, lines) for key, value in data.items()}
        return Value(entries, line)
    if isinstance(data, (list, tuple)):
        items = [_tree(item, (*path, number), line, lines) for number, item in enumerate(data)]
        return Value(items, line)
    if isinstance(data, bool):
        return Value(data, line, str(data).lower())
    if data is None or isinstance(data, (str, int, float)):
        return Value(data, line, "" if data is None else str(data))
    # A date of TOML, or the path that a program gives: a text for us.
    return Value(str(data), line, str(data))
