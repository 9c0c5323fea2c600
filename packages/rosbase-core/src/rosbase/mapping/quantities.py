"""Read one quantity of a payload in SI units, and give a reason for every fault."""

import math
from collections.abc import Callable, Sequence
from typing import TypeAlias

from attrs import field, frozen

from rosbase.mapping.following import MISSING, follow
from rosbase.mapping.known_keys import Keys, is_left_out
from rosbase.mapping.paths import Steps, Way
from rosbase.mapping.reals import to_float
from rosbase.mapping.rejects import Reject
from rosbase.mapping.surplus import Guard, surplus_at

__all__ = ["Components", "Judge", "Numbers", "shared_parent"]

Numbers: TypeAlias = tuple[float, ...]


@frozen
class Components:
    """One alternative of a quantity: the ways to its components, and their limits."""

    name: str
    ways: tuple[Way, ...]
    factor: float
    """The factor from the payload's unit to the SI unit."""
    largest: float
    """The largest absolute value of a component, in the SI unit."""
    is_whole: bool
    """Whether one path leads to a list of all components, and of nothing else."""
    guards: tuple[tuple[Guard, ...], ...]
    """The guards of the indices on each way."""
    keys: tuple[tuple[Keys, ...], ...]
    """The keys known in the objects on each way."""
    shown: tuple[str, ...]
    """The ways from the top of the payload, for people."""
    numeric_strings: bool = False
    sentinels: frozenset[float] = frozenset()
    """Numbers of the payload that mean that there is no reading."""
    absent_is_zero: bool = False
    """Whether the encoder leaves zeros out."""
    has_object: bool = False
    """Whether the vector is zero if only the object for its components is there."""
    finish: Callable[[Numbers], Numbers | Reject] | None = None
    """A function that checks, and may correct, the components together."""
    factors: tuple[float, ...] = field(init=False)

    @factors.default
    def _default_factors(self) -> tuple[float, ...]:
        return tuple(self.factor * way.sign for way in self.ways)


class Judge:
    """Reads a quantity carefully: any payload, any fault."""

    def __init__(self, components: Components) -> None:
        """Prepare to read the components."""
        self._of = components
        self._steps = [way.steps for way in components.ways]
        self._parent = shared_parent(self._steps)

    def read(self, payload: object) -> Numbers | Reject | None:
        """Return the numbers in a payload, the reason for a fault, or None if there are none."""
        return self.judge([payload] * len(self._steps))

    def judge(self, places: Sequence[object]) -> Numbers | Reject | None:
        """Return the numbers, each by its way from its own place."""
        found = [follow(place, way) for place, way in zip(places, self._steps, strict=True)]
        if all(value is MISSING or value is None for value in found):
            return self._nothing(places)
        for place, value, guards in zip(places, found, self._of.guards, strict=True):
            reject = value if isinstance(value, Reject) else surplus_at(place, guards)
            if reject is not None:
                return self._named(reject)
        lacking = [n for n, value in enumerate(found) if value is MISSING]
        if lacking and not self._are_left_out(lacking, places):
            return Reject("incomplete", self._lack(lacking))
        if self._of.is_whole and self._is_longer(places[0]):
            return Reject("wrong_type", f"{self._of.name}: a list of another length")
        return self._convert([0.0 if value is MISSING else value for value in found])

    def _nothing(self, places: Sequence[object]) -> Numbers | Reject | None:
        """Return zeros if the encoder leaves zeros out and the components' object is there."""
        steps, known = self._steps, self._of.keys
        if self._parent is None or not self._of.has_object or not self._may_be_zero(steps):
            return None
        parent = follow(places[0], self._parent)
        if not isinstance(parent, dict) or any(way[-1] in parent for way in steps):
            return None
        misspelt = [n for n, k in enumerate(known) if k[-1].is_misspelt(str(steps[n][-1]), parent)]
        if misspelt:
            return Reject("incomplete", self._lack(misspelt))
        return self._convert([0.0] * len(places)) if known[0][-1].holds_reading(parent) else None

    def _are_left_out(self, lacking: Sequence[int], places: Sequence[object]) -> bool:
        return self._of.absent_is_zero and all(
            is_left_out(places[n], self._steps[n], self._of.keys[n]) for n in lacking
        )

    def _may_be_zero(self, ways: Sequence[Steps]) -> bool:
        return self._of.absent_is_zero and self._are_keys(ways)

    def _are_keys(self, ways: Sequence[Steps]) -> bool:
        return all(way and isinstance(way[-1], str) for way in ways)

    def _lack(self, lacking: Sequence[int]) -> str:
        shown = ", ".join(self._of.shown[n] for n in lacking)
        are_keys = self._are_keys([self._steps[n] for n in lacking])
        is_zero = are_keys and not self._of.absent_is_zero
        hint = "; mapping.absent:=zero if zeros are left out" if is_zero else ""
        return f"{self._of.name} lacks {shown}{hint}"

    def _is_longer(self, place: object) -> bool:
        """Return whether the list holds more than the components."""
        parent = follow(place, self._steps[0][:-1])
        return isinstance(parent, list) and len(parent) != len(self._steps)

    def _convert(self, values: Sequence[object]) -> Numbers | Reject | None:
        if self._of.sentinels and any(self._is_sentinel(value) for value in values):
            return None
        numbers: list[float] = []
        for value, factor in zip(values, self._of.factors, strict=True):
            number = to_float(value, numeric_strings=self._of.numeric_strings)
            if isinstance(number, Reject):
                return self._named(number)
            scaled = number * factor
            if not math.isfinite(scaled):
                return Reject("non_finite", self._of.name)
            if abs(scaled) > self._of.largest:
                said = f"{scaled:.6g} is more than {self._of.largest:.6g}"
                return Reject("out_of_range", f"{self._of.name}: {said}")
            numbers.append(scaled)
        finished = self._of.finish(tuple(numbers)) if self._of.finish else tuple(numbers)
        return self._named(finished) if isinstance(finished, Reject) else finished

    def _is_sentinel(self, value: object) -> bool:
        number = to_float(value, numeric_strings=self._of.numeric_strings)
        return number in self._of.sentinels

    def _named(self, reject: Reject) -> Reject:
        return Reject(reject.reason, f"{self._of.name}: {reject.detail}")


def shared_parent(ways: Sequence[Steps]) -> Steps | None:
    """Return the way to the one place of all components; None if they have several."""
    parents = {way[:-1] for way in ways}
    return parents.pop() if len(parents) == 1 and all(ways) else None
