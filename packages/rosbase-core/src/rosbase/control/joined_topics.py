"""Joins the topics of several programs into one list. Pure."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable, Iterable
    from typing import Any

    from rosbase.control.shapes import Topic

__all__ = ["joined_topics"]


def joined_topics(
    answers: Iterable[tuple[int, Iterable[Any]]], group: Callable[[int], int] = lambda _: 0
) -> dict[tuple[str, int], Topic]:
    """Return each topic once, with its ends in all programs.

    Args:
        answers: The pid of each process, with what it answers to `topic.list`.
        group: Returns the group of a process; topics of one name in two groups stay two.

    Returns:
        The topics by name and group, sorted.
    """
    found: dict[tuple[str, int], Topic] = {}
    for pid, topics in answers:
        for one in topics:
            topic = found.setdefault(
                (one["name"], group(pid)),
                {"name": one["name"], "types": [], "publishers": [], "subscriptions": []},
            )
            if one["type"] not in topic["types"]:
                topic["types"].append(one["type"])
            topic["publishers"] += _with_pid(one["publishers"], pid)
            topic["subscriptions"] += _with_pid(one["subscriptions"], pid)
    return {key: found[key] for key in sorted(found)}


def _with_pid(ends: Iterable[Any], pid: int) -> list[Any]:
    return [{**end, "pid": pid} for end in ends]
