"""Reads a vector or a quaternion out of a payload, in SI units, or says why it cannot."""

import math
import re
from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any, TypeAlias

from rosbase.mapping.paths import MISSING, Path, Steps, follow, variants
from rosbase.mapping.rejects import Reject

__all__ = ["Numbers", "QuantityReader", "compile_quantity", "unit_quaternion"]

Numbers: TypeAlias = tuple[float, ...]

QuantityReader: TypeAlias = Callable[[object], Numbers | Reject | None]
"""Gives finite numbers in SI units; None if the payload has nothing of the quantity."""

# As JSON writes numbers: Python's float() would also take 'nan', '1_0' and Arabic digits.
_NUMBER = re.compile(r"-?(0|[1-9]\d*)(\.\d+)?([eE][-+]?\d+)?", re.ASCII)

# Far beyond what any sensor measures, in any of the SI units: such a number is an error.
_LARGEST = 1e9
_LARGEST_SQUARE = _LARGEST * _LARGEST

# Nearer to 1 than this is what rounding leaves, and is published as it was reported.
_ROUNDING = 1e-6


def compile_quantity(
    name: str, paths: Sequence[Path], factor: float, *, numeric_strings: bool = False
) -> QuantityReader:
    """A reader for the numbers at `paths`.

    Args:
        name: The quantity, for messages.
        paths: Where the components are, in the order in which they are given back. Their
            alternatives belong together: the first of which anything is there counts.
        factor: What each is multiplied by.
        numeric_strings: Whether a text that is a JSON number counts as one.

    Raises:
        MappingError: Some paths have more alternatives than others.
    """
    readers = [
        _compile_variant(name, steps, factor, numeric_strings) for steps in variants(paths, name)
    ]
    if len(readers) == 1:
        return readers[0]

    def read_first(payload: object) -> Numbers | Reject | None:
        for read in readers:
            numbers = read(payload)
            if numbers is not None:
                return numbers
        return None

    return read_first


def _compile_variant(
    name: str, paths: Sequence[Steps], factor: float, numeric_strings: bool
) -> QuantityReader:
    shared = _shared_parent(paths)

    def read_carefully(payload: object) -> Numbers | Reject | None:
        found = [follow(payload, steps) for steps in paths]
        missing = sum(value is MISSING for value in found)
        if missing:
            return None if missing == len(found) else Reject("incomplete", name)
        if shared is not None and _is_longer_list(follow(payload, shared[0]), shared[1]):
            return Reject("wrong_type", f"{name}: a list of another length")
        numbers: list[float] = []
        for value in found:
            number = _to_float(value, numeric_strings)
            if isinstance(number, Reject):
                return Reject(number.reason, f"{name}: {number.detail}")
            scaled = number * factor
            if not math.isfinite(scaled):
                return Reject("non_finite", name)
            if abs(scaled) > _LARGEST:
                return Reject("out_of_range", name)
            numbers.append(scaled)
        return tuple(numbers)

    if shared is None:
        return read_carefully
    parent_steps, keys = shared
    get_components = itemgetter(*keys)
    are_indices = sorted(keys, key=str) == list(range(len(keys)))

    def read(payload: object) -> Numbers | Reject | None:
        # The usual case: all components in one place, all of them floats. Whatever is
        # different goes the careful way, which alone decides what it means.
        try:
            parent: Any = payload
            for step in parent_steps:
                parent = parent[step]
            numbers: Numbers = get_components(parent)
        except (KeyError, IndexError, TypeError):
            return read_carefully(payload)
        if are_indices and len(parent) != len(keys):
            return read_carefully(payload)
        for number in numbers:
            if type(number) is not float:
                return read_carefully(payload)
        if factor != 1.0:
            numbers = tuple([number * factor for number in numbers])
        squares = sum([number * number for number in numbers])
        # Neither NaN nor an infinity is less than anything.
        return numbers if squares < _LARGEST_SQUARE else read_carefully(payload)

    return read


def unit_quaternion(numbers: Numbers, tolerance: float) -> Numbers | Reject:
    """The quaternion with norm 1, if it was within `tolerance` of it.

    Args:
        numbers: Four components, in any order.
        tolerance: How far from 1 the norm may be.
    """
    norm = math.hypot(*numbers)
    error = abs(norm - 1.0)
    if error <= _ROUNDING:
        return numbers
    if error <= tolerance:
        return tuple([number / norm for number in numbers])
    return Reject("bad_quaternion", f"norm {norm:.6g}")


def _shared_parent(paths: Sequence[Steps]) -> tuple[Steps, list[str | int]] | None:
    """The steps to the place where all components stand, and their keys there."""
    parents = {steps[:-1] for steps in paths}
    return (parents.pop(), [steps[-1] for steps in paths]) if len(parents) == 1 else None


def _is_longer_list(parent: object, keys: Sequence[str | int]) -> bool:
    """Whether a list has more in it than the components that it stands for."""
    covers = sorted(keys, key=str) == list(range(len(keys)))
    return covers and isinstance(parent, list) and len(parent) != len(keys)


def _to_float(value: object, numeric_strings: bool) -> float | Reject:
    if isinstance(value, str) and numeric_strings and _NUMBER.fullmatch(value.strip()):
        return float(value)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return Reject("wrong_type", _kind(value))
    try:
        return float(value)
    except OverflowError:
        return Reject("out_of_range", "an integer beyond any double")


def _kind(value: object) -> str:
    names = {type(None): "null", bool: "true or false", str: "text", list: "a list"}
    return names.get(type(value), "an object")
