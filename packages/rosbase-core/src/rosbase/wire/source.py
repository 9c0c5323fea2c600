"""The lines of a function that is compiled for one message class."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

__all__ = ["Source"]


class Source:
    """Lines of Python, and the objects that they name."""

    def __init__(self, signature: str) -> None:
        """Start a function, such as `write(message, put, pos)`."""
        self._name = signature.partition("(")[0]
        self._lines = [f"def {signature}:"]
        self._indent = 1
        self._names: dict[str, Any] = {}
        self._count = 0

    def line(self, text: str) -> None:
        """Add a line."""
        self._lines.append("    " * self._indent + text)

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Add a line, and indent those within."""
        self.line(head)
        self._indent += 1
        yield
        self._indent -= 1

    def new(self, prefix: str) -> str:
        """Return a name that nothing has."""
        self._count += 1
        return f"{prefix}{self._count}"

    def name_of(self, thing: Any, prefix: str) -> str:
        """Return a name for an object that the lines use."""
        for name, known in self._names.items():
            if known is thing:
                return name
        name = self.new(prefix)
        self._names[name] = thing
        return name

    def compile(self) -> Callable[..., Any]:
        """Return the function."""
        text = "\n".join(self._lines)
        made: dict[str, Any] = dict(self._names)
        exec(compile(text, f"<{self._name}>", "exec"), made)
        function: Callable[..., Any] = made[self._name]
        return function
