"""Rows that take turns, and their ratios."""

import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TypeVar

FigureT = TypeVar("FigureT")


def take_turns(
    measure: Callable[[str], FigureT], names: Iterable[str], turns: int
) -> dict[str, list[FigureT]]:
    """What each row measured in each turn."""
    rows: dict[str, list[FigureT]] = {name: [] for name in names}
    for number in range(turns):
        for name in rows if number % 2 else reversed(rows):
            rows[name].append(measure(name))
    return rows


def ratio(rows: Mapping[str, Sequence[float]], name: str, to: str) -> float:
    """The median of the turns' ratios of one row to another."""
    return statistics.median(a / b for a, b in zip(rows[name], rows[to], strict=True))
