"""A whole mapping: how the payload of a device becomes samples. Data in, a function out."""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias, TypeVar

from attrs import field, frozen

from rosbase.errors import MappingError
from rosbase.mapping.assembly import Row, Slot
from rosbase.mapping.batches import compile_batch_reader
from rosbase.mapping.clashes import check_clashes, check_conditions
from rosbase.mapping.conditions import compile_condition
from rosbase.mapping.path_text import parse_condition, parse_path
from rosbase.mapping.paths import EACH, Condition, Steps, Way, variants
from rosbase.mapping.payload_reading import FrameReader, Plan, batch_reader, single_reader
from rosbase.mapping.quantities import Components, Numbers
from rosbase.mapping.quick_reading import compile_reader
from rosbase.mapping.rejects import Reject
from rosbase.mapping.surplus import Covered, covered_indices, guards_of
from rosbase.mapping.times import Dates, TimeMapping

__all__ = ["ABSENT", "LARGEST", "PayloadMapping", "Quantity"]

T = TypeVar("T")
U = TypeVar("U")

_Alternatives: TypeAlias = dict[str, list[tuple[Way, ...]]]
"""By quantity: for each alternative the ways to its components."""

ABSENT = ("missing", "zero")
"""What `PayloadMapping.absent` may be."""

LARGEST = 1e9
"""Far beyond what any sensor measures, in any SI unit: such a number is an error."""


@frozen
class Quantity:
    """One quantity of a payload, such as a vector: where its components are."""

    name: str
    paths: tuple[str, ...] = ()
    """A path for each component, or one to a list of them; none if the device has none."""
    components: tuple[str, ...] = ("x", "y", "z")
    """The components in the order in which a sample has them."""
    written: tuple[str, ...] = ()
    """The order in which the paths, or the list, give them; the same unless stated."""
    factor: float = 1.0
    """By what each number is multiplied to be in the SI unit."""
    largest: float = LARGEST
    """The largest absolute value of a component, in the SI unit."""
    required: bool = False
    """Whether there is no sample without it."""
    finish: Callable[[Numbers], Numbers | Reject] | None = None
    """Checks, and perhaps corrects, the components together."""

    def alternatives(self) -> list[tuple[Way, ...]]:
        """Return the ways to the components, in their order, for each alternative.

        Raises:
            MappingError: A path is none, or there are too few or too many.
        """
        paths = [parse_path(text) for text in self.paths]
        count = len(self.components)
        if self.is_whole:
            paths = [
                tuple(Way((*way.steps, index), way.sign) for way in paths[0])
                for index in range(count)
            ]
        if len(paths) != count:
            raise MappingError(
                f"mapping.{self.name}.paths takes {count} paths or one, not {len(paths)}"
            )
        order = [(self.written or self.components).index(name) for name in self.components]
        return variants([paths[at] for at in order], self.name)

    @property
    def is_whole(self) -> bool:
        """Whether one path leads to a list of all components."""
        return len(self.paths) == 1 and len(self.components) > 1


@frozen
class PayloadMapping:
    """What a payload holds, and where. See `docs/mapping.md` for the language."""

    quantities: tuple[Quantity, ...]
    time: TimeMapping = field(factory=TimeMapping)
    select: tuple[str, ...] = ()
    """Conditions such as `T=1002` that a payload must meet."""
    numeric_strings: bool = False
    """Whether `"1.5"` counts as 1.5."""
    absent: str = "missing"
    """`zero` if the encoder leaves numbers out that are zero."""

    @property
    def is_batch(self) -> bool:
        """Whether a message holds several samples.

        Raises:
            MappingError: A path is none, or `[*]` is not in all paths of the quantities.
        """
        return _is_batch(self._alternatives())

    def compile(
        self,
        make: Callable[[Row], T],
        *,
        device_time: bool = False,
        nothing: str = "nothing_known",
    ) -> FrameReader[T]:
        """Return the function that reads a frame.

        Args:
            make: Makes a sample of a list: the numbers of each quantity, or None; the date in
                nanoseconds since 1970, or None; and a tuple of `Reject`, which say what was
                left out of the sample and why.
            device_time: Whether dates are read.
            nothing: The reason for payloads in which there is nothing of the mapping.

        Raises:
            MappingError: The description contradicts itself, lacks something, or could mean
                two things.
        """
        self._check_values()
        ways = self._alternatives()
        is_batch = _is_batch(ways)
        self.time.check(is_batch=is_batch, is_wanted=device_time)
        conditions = [parse_condition(text) for text in self.select]
        check_conditions(conditions)
        check_clashes({**_steps(ways), **(self._time_steps() if device_time else {})})
        used = {n: quantity for n, quantity in enumerate(self.quantities) if quantity.paths}
        plan = Plan(
            conditions=tuple(compile_condition(condition) for condition in conditions),
            slots=tuple(Slot(n, q.name, q.required) for n, q in used.items()),
            size=len(self.quantities),
            nothing=nothing,
            dates=self._dates() if device_time else None,
            interval=self.time.compile_interval(numeric_strings=self.numeric_strings),
        )
        covered = self._covered(ways, conditions)
        components = [self._components(q, ways[q.name], covered) for q in used.values()]
        if is_batch:
            batches = [[compile_batch_reader(c) for c in found] for found in components]
            return batch_reader(plan, [_first_of(readers) for readers in batches], make)
        singles = [[compile_reader(c) for c in found] for found in components]
        return single_reader(plan, [_first_of(readers) for readers in singles], make)

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
        return {q.name: q.alternatives() for q in self.quantities if q.paths}

    def _time_steps(self) -> dict[str, list[list[Steps]]]:
        alternatives = variants(self.time.parsed(), "mapping.time") if self.time.paths else []
        return _steps({"the time": alternatives})

    def _dates(self) -> Dates:
        return self.time.compile(
            numeric_strings=self.numeric_strings, absent_is_zero=self.absent == "zero"
        )

    def _covered(self, ways: _Alternatives, conditions: Sequence[Condition]) -> Covered:
        """The indices that the mapping names."""
        steps = {**_steps(ways), **self._time_steps()}
        named = [way for found in steps.values() for components in found for way in components]
        return covered_indices(
            named + [path for condition in conditions for path in condition.paths]
        )

    def _components(
        self, quantity: Quantity, alternatives: Sequence[tuple[Way, ...]], covered: Covered
    ) -> list[Components]:
        """What there is to know of a quantity, for each alternative."""
        is_whole = quantity.is_whole
        return [
            Components(
                name=quantity.name,
                ways=ways,
                factor=quantity.factor,
                largest=quantity.largest,
                is_whole=is_whole,
                guards=tuple(tuple(guards_of(w, covered, is_whole=is_whole)) for w in ways),
                numeric_strings=self.numeric_strings,
                absent_is_zero=self.absent == "zero",
                has_object=len({w.steps[:-1] for w in ways}) == 1 and len(ways[0].steps) > 1,
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


def _first_of(readers: Sequence[Callable[[Any], U | None]]) -> Callable[[Any], U | None]:
    """Return what gives the numbers of the first alternative of which anything is there."""
    if len(readers) == 1:
        return readers[0]

    def read_first(payload: object) -> U | None:
        for read in readers:
            found = read(payload)
            if found is not None:
                return found
        return None

    return read_first
