"""A whole mapping, compiled from data to a function that reads frames."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeAlias, TypeVar

from attrs import field, frozen

from rosbase.errors import MappingError
from rosbase.mapping.alternatives import compile_alternatives
from rosbase.mapping.assembly import Row, Slot
from rosbase.mapping.batches import compile_batch_reader
from rosbase.mapping.clashes import check_clashes, check_conditions
from rosbase.mapping.conditions import compile_condition
from rosbase.mapping.description import Quantity, TimeMapping
from rosbase.mapping.intervals import IntervalReader, compile_interval, interval_path
from rosbase.mapping.known_keys import KnownKeys
from rosbase.mapping.path_text import parse_condition
from rosbase.mapping.paths import EACH, Condition, Steps, Way, show_steps
from rosbase.mapping.payload_reading import FrameReader, Plan, batch_reader, single_reader
from rosbase.mapping.quantities import Components
from rosbase.mapping.quick_reading import compile_reader
from rosbase.mapping.reachable import check_reachable
from rosbase.mapping.surplus import Covered, covered_indices, guards_of
from rosbase.mapping.times import Dates
from rosbase.mapping.ways import check_time, quantity_ways, time_ways

__all__ = ["ABSENT", "PayloadMapping"]

SampleT = TypeVar("SampleT")

_Alternatives: TypeAlias = dict[str, list[tuple[Way, ...]]]
"""The ways to the components of each alternative, by quantity."""

ABSENT = ("missing", "zero")
"""The values of `PayloadMapping.absent`."""


class _Names(NamedTuple):
    """The keys and indices that a mapping names."""

    read: list[Steps]
    """The ways to the numbers of all quantities."""
    covered: Covered
    keys: KnownKeys


@frozen
class PayloadMapping:
    """The description of a payload. See `docs/mapping.md` for the language."""

    quantities: tuple[Quantity, ...]
    time: TimeMapping = field(factory=TimeMapping)
    select: tuple[str, ...] = ()
    """Conditions such as `T=1002` that a payload must meet."""
    numeric_strings: bool = False
    """Whether `"1.5"` counts as 1.5."""
    sentinels: tuple[float, ...] = ()
    """Numbers that mean that there is no reading, as the payload has them."""
    absent: str = "missing"
    """The meaning of a number that the payload leaves out: `missing`, or `zero`."""

    def compile(
        self,
        make: Callable[[Row], SampleT],
        *,
        device_time: bool = False,
        nothing: str = "nothing_known",
    ) -> FrameReader[SampleT]:
        """Return the function that reads a frame.

        Args:
            make: Makes a sample of a list. The list has the numbers of each quantity, or None, and
                the date in nanoseconds since 1970, or None. It ends with a tuple: a `Reject` for
                each quantity, or date, that was left out of the sample.
            device_time: Whether to read dates.
            nothing: The reason for payloads without any quantity of the mapping.

        Raises:
            MappingError: The description contradicts itself, lacks something, or could mean
                two things.
        """
        self._check_values()
        ways = self._alternatives()
        is_batch = _is_batch(ways)
        check_time(self.time, is_batch=is_batch, is_wanted=device_time)
        conditions = [
            parse_condition(text, numeric_strings=self.numeric_strings) for text in self.select
        ]
        check_conditions(conditions)
        read = {**_steps(ways), **(self._time_steps() if device_time else {})}
        check_clashes(read)
        check_reachable(conditions, read)
        names = self._names(ways, conditions)
        used = {n: quantity for n, quantity in enumerate(self.quantities) if quantity.paths}
        plan = Plan(
            conditions=tuple(compile_condition(condition) for condition in conditions),
            slots=tuple(Slot(n, q.name, q.required) for n, q in used.items()),
            size=len(self.quantities),
            nothing=nothing,
            dates=self._dates(names.keys) if device_time else None,
            interval=self._interval(),
        )
        components = [self._components(q, ways[q.name], names) for q in used.values()]
        if is_batch:
            batches = [compile_alternatives(found, compile_batch_reader) for found in components]
            return batch_reader(plan, batches, make)
        singles = [compile_alternatives(found, compile_reader) for found in components]
        return single_reader(plan, singles, make)

    def _check_values(self) -> None:
        if self.absent not in ABSENT:
            raise MappingError(f"mapping.absent is {' or '.join(ABSENT)}, not {self.absent!r}")
        if not any(quantity.paths for quantity in self.quantities):
            raise MappingError("the mapping names no quantity: set mapping.*.paths or a preset")
        for quantity in self.quantities:
            if quantity.required and not quantity.paths:
                raise MappingError(
                    f"{quantity.name} is required, but mapping.{quantity.name}.paths is empty"
                )

    def _alternatives(self) -> _Alternatives:
        return {
            q.name: quantity_ways(q, numeric_strings=self.numeric_strings)
            for q in self.quantities
            if q.paths
        }

    def _time_steps(self) -> dict[str, list[list[Steps]]]:
        return _steps({"the time": time_ways(self.time, numeric_strings=self.numeric_strings)})

    def _dates(self, known: KnownKeys) -> Dates:
        return Dates(
            self.time,
            known,
            numeric_strings=self.numeric_strings,
            absent_is_zero=self.absent == "zero",
        )

    def _interval(self) -> IntervalReader | None:
        if not self.time.interval:
            return None
        return compile_interval(self.time.interval, numeric_strings=self.numeric_strings)

    def _names(self, ways: _Alternatives, conditions: Sequence[Condition]) -> _Names:
        """Return the keys and indices that the mapping names."""
        read = _flat(_steps(ways))
        interval = interval_path(self.time.interval, numeric_strings=self.numeric_strings)
        named = [*read, *_flat(self._time_steps()), *(way.steps for way in interval)]
        selected = [path for condition in conditions for path in condition.paths]
        return _Names(read, covered_indices(named + selected), KnownKeys(named, conditions))

    def _components(
        self, quantity: Quantity, alternatives: Sequence[tuple[Way, ...]], names: _Names
    ) -> list[Components]:
        """Return the components of a quantity for each alternative."""
        is_whole = quantity.is_whole
        return [
            Components(
                name=quantity.name,
                ways=ways,
                factor=quantity.factor,
                largest=quantity.largest,
                is_whole=is_whole,
                guards=tuple(
                    tuple(guards_of(w, names.covered, names.read, is_whole=is_whole)) for w in ways
                ),
                keys=tuple(names.keys.along(way.steps) for way in ways),
                shown=tuple(show_steps(way.steps) for way in ways),
                numeric_strings=self.numeric_strings,
                sentinels=frozenset(self.sentinels),
                absent_is_zero=self.absent == "zero",
                has_object=_has_object(ways),
                finish=quantity.finish,
            )
            for ways in alternatives
        ]


def _is_batch(alternatives: _Alternatives) -> bool:
    each = {EACH in w.steps for found in alternatives.values() for ways in found for w in ways}
    if len(each) > 1:
        raise MappingError("[*] is in all paths of all quantities, or in none")
    return True in each


def _steps(alternatives: _Alternatives) -> dict[str, list[list[Steps]]]:
    return {
        name: [[way.steps for way in ways] for ways in found]
        for name, found in alternatives.items()
    }


def _has_object(ways: Sequence[Way]) -> bool:
    """Return whether the components stand together below the top of the payload."""
    return len({way.steps[:-1] for way in ways}) == 1 and len(ways[0].steps) > 1


def _flat(ways: Mapping[str, Sequence[Sequence[Steps]]]) -> list[Steps]:
    return [steps for found in ways.values() for components in found for steps in components]
