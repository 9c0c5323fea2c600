"""Stand-ins for attributes, which raise a clear error until the constructor sets them."""

from typing import Any

__all__ = ["SetByConstructor", "must_call_base"]


def must_call_base(built: object, arguments: str) -> str:
    """Return the error text for a constructor that has not called its base class's."""
    return f"{type(built).__name__}.__init__ must first call super().__init__({arguments})"


class SetByConstructor:
    """Explains why an attribute is missing, until the constructor has set it.

    `__getattr__` could do so too. But with it, Python up to 3.11 takes twice as long for every
    attribute of an object, and programs read dozens of them in a tick.
    """

    __slots__ = ("_arguments", "_name")

    def __init__(self, arguments: str, name: str = "") -> None:
        """Prepare the explanation.

        Args:
            arguments: What the base class's constructor takes.
            name: Name of the attribute; by default the one that it gets in its class.
        """
        self._arguments, self._name = arguments, name

    def __set_name__(self, owner: type, name: str) -> None:
        """Take the name of the attribute."""
        self._name = name

    def __get__(self, built: Any, owner: type) -> Any:
        """Raise the explanation. Python calls it while the object has no such attribute.

        Raises:
            AttributeError: There is no such attribute, or not yet.
        """
        if built is None:
            # As if it were not there: it is no default of a dataclass, for example.
            raise AttributeError(f"type object {owner.__name__!r} has no attribute {self._name!r}")
        if built._is_initialised:
            raise AttributeError(f"{owner.__name__!r} object has no attribute {self._name!r}")
        # With a name of its own, Python adds no guess at what was meant.
        raise AttributeError(must_call_base(built, self._arguments), name="", obj=None)
