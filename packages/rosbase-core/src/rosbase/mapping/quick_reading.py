"""Read quantities quickly in the usual case, and carefully otherwise."""

from collections.abc import Callable
from functools import partial
from operator import itemgetter
from typing import Any, NamedTuple, TypeAlias

from rosbase.mapping.conditions import compile_where
from rosbase.mapping.following import follow
from rosbase.mapping.paths import Steps, Where
from rosbase.mapping.quantities import Components, Judge, Numbers, shared_parent
from rosbase.mapping.rejects import Reject
from rosbase.mapping.surplus import surplus_at

__all__ = ["Reader", "compile_reader"]

Reader: TypeAlias = Callable[[Any], Numbers | Reject | None]
"""Function from a payload to finite numbers in SI units; None if the quantity is absent."""


def compile_reader(components: Components) -> Reader:
    """Return a reader of the components in one payload.

    Usually all components are in one place, and are numbers within the full scale. `Judge` reads
    all other payloads, and it alone refuses.
    """
    careful = Judge(components).read
    ways = [way.steps for way in components.ways]
    parent = shared_parent(ways)
    keys = [way[-1] for way in ways if way and isinstance(way[-1], (str, int))]
    is_usual = parent is not None and len(keys) == len(ways) and not components.sentinels
    if parent is None or not is_usual or len(keys) not in (3, 4):
        return careful
    place = _Place(*_locator(parent), itemgetter(*keys), components, careful)
    return _read_three(place) if len(keys) == 3 else _read_four(place)


class _Place(NamedTuple):
    """The one place of all components, and how to read them."""

    locate: Callable[[Any], Any] | None
    """Follows the way up to its last condition; None if there is no condition."""
    steps: tuple[Any, ...]
    """The keys and indices after the last condition."""
    take: Callable[[Any], tuple[Any, ...]]
    of: Components
    careful: Reader


def _read_three(place: _Place) -> Reader:
    locate, steps, take, of, careful = place
    a, b, c = of.factors
    is_scaled = of.factors != (1.0, 1.0, 1.0)
    largest_square = of.largest * of.largest
    is_whole, has_more = of.is_whole, _has_more(of)

    def read(payload: Any) -> Numbers | Reject | None:
        try:
            parent = payload if locate is None else locate(payload)
            for step in steps:
                parent = parent[step]
            numbers = x, y, z = take(parent)
        except (KeyError, IndexError, TypeError):
            return careful(payload)
        if not (x.__class__ is float and y.__class__ is float and z.__class__ is float):
            floats = _as_floats(numbers)
            if floats is None:
                return careful(payload)
            numbers = x, y, z = floats
        if is_scaled:
            numbers = x, y, z = x * a, y * b, z * c
        # False for NaN and infinities too. If the sum of the squares is within the full scale,
        # each number is.
        if not x * x + y * y + z * z < largest_square or (is_whole and len(parent) != 3):
            return careful(payload)
        return careful(payload) if has_more is not None and has_more(payload) else numbers

    return read


def _read_four(place: _Place) -> Reader:
    locate, steps, take, of, careful = place
    a, b, c, d = of.factors
    is_scaled = of.factors != (1.0, 1.0, 1.0, 1.0)
    largest_square = of.largest * of.largest
    is_whole, has_more, finish = of.is_whole, _has_more(of), of.finish

    def read(payload: Any) -> Numbers | Reject | None:
        try:
            parent = payload if locate is None else locate(payload)
            for step in steps:
                parent = parent[step]
            numbers = x, y, z, w = take(parent)
        except (KeyError, IndexError, TypeError):
            return careful(payload)
        if not (x.__class__ is y.__class__ is z.__class__ is w.__class__ is float):
            floats = _as_floats(numbers)
            if floats is None:
                return careful(payload)
            numbers = x, y, z, w = floats
        if is_scaled:
            numbers = x, y, z, w = x * a, y * b, z * c, w * d
        if not x * x + y * y + z * z + w * w < largest_square or (is_whole and len(parent) != 4):
            return careful(payload)
        if has_more is not None and has_more(payload):
            return careful(payload)
        if finish is None:
            return numbers
        finished = finish(numbers)
        return careful(payload) if isinstance(finished, Reject) else finished

    return read


def _as_floats(numbers: tuple[Any, ...]) -> tuple[float, ...] | None:
    """Return the numbers as floats; None if one is no number, or too large for a float."""
    for number in numbers:
        if number.__class__ is not float and number.__class__ is not int:
            return None
    try:
        return tuple(map(float, numbers))
    except OverflowError:
        return None


def _has_more(of: Components) -> Callable[[Any], object] | None:
    """Return a function that finds surplus elements; None if no way has an index."""
    guards = tuple(dict.fromkeys(guard for guards in of.guards for guard in guards))
    return partial(surplus_at, guards=guards) if guards else None


def _locator(parent: Steps) -> tuple[Callable[[Any], Any] | None, Steps]:
    """Return a function that follows the way up to its last condition, and the rest."""
    at = max((n for n, step in enumerate(parent) if isinstance(step, Where)), default=-1)
    if at < 0:
        return None, parent
    before, where, after = parent[:at], parent[at], parent[at + 1 :]
    if any(isinstance(step, Where) for step in before):
        return partial(follow, steps=parent[: at + 1]), after
    assert isinstance(where, Where)
    pick = compile_where(where)
    if not before:
        return pick, after

    def locate(payload: Any) -> Any:
        value = payload
        for step in before:
            value = value[step]
        return pick(value)

    return locate, after
