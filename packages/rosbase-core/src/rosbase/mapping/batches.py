"""Read messages with several samples: one sample for each element of a list."""

from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

from attrs import evolve

from rosbase.mapping.following import MISSING
from rosbase.mapping.paths import EACH, Steps, Way
from rosbase.mapping.quantities import Components, Judge, Numbers
from rosbase.mapping.quick_reading import Reader, compile_reader
from rosbase.mapping.rejects import Reject
from rosbase.mapping.surplus import Guard, elements_at, surplus_at

__all__ = ["BatchReader", "compile_batch_reader"]

BatchReader: TypeAlias = Callable[[Any], "list[Numbers | Reject | None] | Reject | None"]
"""Function from a payload to the numbers of each sample; None if the quantity is absent."""


_List: TypeAlias = tuple[Steps, Sequence[Guard]]
"""The way to a list of elements, and the guards of the indices on that way."""


def compile_batch_reader(components: Components) -> BatchReader:
    """Return a reader of components whose ways all have a `[*]`."""
    lists = [way.steps[: way.steps.index(EACH)] for way in components.ways]
    guards = [[g for g in guards if EACH not in g.to_list] for guards in components.guards]
    inner = evolve(
        components,
        ways=tuple(Way(_behind(way.steps), way.sign) for way in components.ways),
        guards=tuple(
            tuple(g._replace(to_list=_behind(g.to_list)) for g in found if EACH in g.to_list)
            for found in components.guards
        ),
        keys=tuple(
            keys[way.steps.index(EACH) + 1 :]
            for way, keys in zip(components.ways, components.keys, strict=True)
        ),
    )
    if len(set(lists)) == 1:
        merged = [guard for found in guards for guard in found]
        return _rows(components.name, (lists[0], merged), compile_reader(inner))
    return _columns(components.name, list(zip(lists, guards, strict=True)), Judge(inner))


def _behind(steps: Steps) -> Steps:
    """Return the steps after the `[*]`."""
    return steps[steps.index(EACH) + 1 :]


def _rows(name: str, to_list: _List, read_one: Reader) -> BatchReader:
    """Return a reader for payloads with all components of a sample in one element."""

    def read(payload: Any) -> list[Numbers | Reject | None] | Reject | None:
        columns = _columns_of(payload, [to_list], name)
        if isinstance(columns, Reject):
            return columns
        return [read_one(element) for element in columns[0]] or None

    return read


def _columns(name: str, lists: Sequence[_List], judge: Judge) -> BatchReader:
    """Return a reader for payloads with a separate list for each component."""

    def read(payload: Any) -> list[Numbers | Reject | None] | Reject | None:
        columns = _columns_of(payload, lists, name)
        if isinstance(columns, Reject):
            return columns
        counts = {len(column) for column in columns if column}
        if len(counts) > 1:
            lengths = ", ".join(str(len(column)) for column in columns)
            return Reject("uneven", f"{name}: lists of {lengths} elements")
        count = max(counts, default=0)
        rows = zip(*(column or [MISSING] * count for column in columns), strict=True)
        return [judge.judge(row) for row in rows] or None

    return read


def _columns_of(
    payload: object, lists: Sequence[_List], name: str
) -> list[Sequence[object]] | Reject:
    """Return the elements of the `[*]` of each component, or the reason to refuse them."""
    found = [elements_at(payload, to_list) for to_list, _ in lists]
    columns: list[Sequence[object]] = []
    for elements, (_, guards) in zip(found, lists, strict=True):
        reject = elements if isinstance(elements, Reject) else None
        if reject is None and any(found):
            reject = surplus_at(payload, guards)
        if reject is not None:
            return Reject(reject.reason, f"{name}: {reject.detail}")
        columns.append(elements if isinstance(elements, list) else [])
    return columns
