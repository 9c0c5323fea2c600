"""Faster constructors for messages.

The constructors that attrs generates look up each slot by name, and call every validator. These set
the slots directly, and call a validator only for an unusual value. They take a quarter less time,
and a program constructs several messages for each sample.
"""

from collections.abc import Callable
from typing import Any

from attrs import Attribute
from attrs.validators import get_disabled

__all__ = ["put_into_slots", "usual"]

_USUAL = "__usual__"

_Check = Callable[[Any, "Attribute[Any]", Any], None]


def usual(kind: type, size: int | None = None) -> Callable[[_Check], _Check]:
    """Return a decorator that says which values a validator accepts as they are.

    Args:
        kind: Their class, without subclasses.
        size: Their length; None for any.
    """

    def declare(check: _Check) -> _Check:
        setattr(check, _USUAL, (kind, size))
        return check

    return declare


def put_into_slots(cls: Any) -> None:
    """Replace the constructor of a frozen attrs class, which has slots and constant defaults."""
    # No name of ROS begins with an underscore, so no field hides any of these.
    names: dict[str, Any] = {"_type": type, "_len": len, "_is_disabled": get_disabled}
    arguments, lines, checks = ["self"], [], []
    for one in cls.__attrs_attrs__:
        value, put = one.alias, getattr(cls, one.name).__set__
        names |= {f"_default_{value}": one.default, f"_put_{value}": put}
        arguments.append(f"{value}=_default_{value}")
        lines.append(f"_put_{value}(self, {value})")
        if one.validator is not None:
            kind, size = getattr(one.validator, _USUAL, (None, None))
            names |= {f"_{value}": one, f"_check_{value}": one.validator, f"_kind_{value}": kind}
            is_unusual = f"_type({value}) is not _kind_{value}"
            if size is not None:
                is_unusual += f" or _len({value}) != {size}"
            checks.append(f"if ({is_unusual}) and not _is_disabled():")
            checks.append(f"    _check_{value}(self, _{value}, {value})")
    if not lines:
        return
    text = "\n    ".join([f"def __init__({', '.join(arguments)}):", *lines, *checks])
    exec(compile(text, f"<constructor of {cls.__name__}>", "exec"), names)
    made, before = names["__init__"], cls.__init__
    made.__annotations__, made.__qualname__ = before.__annotations__, before.__qualname__
    made.__module__ = before.__module__
    cls.__init__ = made
