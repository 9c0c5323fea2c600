"""Ask all programs what they have: one round of questions, and the survey that it gives."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from rosbase import ControlError
from rosbase.control.buses import buses
from rosbase.control.gathering import gather
from rosbase.control.joined_topics import joined_topics
from rosbase.control.shapes import Process, Topic
from rosbase.control.time_limit import TimeLimit
from rosbase_view.attached.choosing import chosen
from rosbase_view.reports import NodeRow, Survey, TopicKey

__all__ = ["survey"]

_ASKS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("process", {}),
    ("topic.list", {}),
    ("node.list", {}),
    ("statistics", {}),
)


def survey(
    name: str | None,
    on_silent: Callable[[str], object],
    silent_until: dict[str, TimeLimit],
) -> Survey:
    """Return what runs now, of all programs or of one and its child processes.

    Args:
        name: A program or its pid; None for all.
        on_silent: Called with a line for each program that does not answer within a second.
        silent_until: Kept between calls, so that such a program is left out for five seconds.

    Raises:
        ControlError: No program has that name, or several have.
    """
    replies = gather(_ASKS, 1.0, None, on_silent, silent_until)
    answers = {reply.pid: reply.answers for reply in replies}
    all_processes = [found[0] for found in answers.values() if _is_answer(found[0])]
    processes = chosen(all_processes, name)
    own = {process["pid"]: answers[process["pid"]] for process in processes}
    loops: list[Any] = [{**one, "pid": pid} for pid, one in _each(own, 3, "programs")]
    return Survey(processes, _topics(own, processes), _nodes(own), loops)


def _is_answer(answer: object) -> bool:
    return not isinstance(answer, ControlError)


def _each(own: Mapping[int, list[Any]], number: int, key: str) -> list[tuple[int, Any]]:
    """Return the items of one answer of each process; a refusal has none."""
    return [
        (pid, one)
        for pid, answers in own.items()
        if _is_answer(answers[number])
        for one in answers[number].get(key, ())
    ]


def _topics(own: Mapping[int, list[Any]], processes: Sequence[Process]) -> dict[TopicKey, Topic]:
    """Return the topics of each group of processes that hear each other."""
    first_of = {pid: min(bus.pids) for bus in buses(processes) for pid in bus.pids}
    lists = [(pid, found[1]["topics"]) for pid, found in own.items() if _is_answer(found[1])]
    return joined_topics(lists, first_of.__getitem__)


def _nodes(own: Mapping[int, list[Any]]) -> list[NodeRow]:
    rows = []
    for pid, node in _each(own, 2, "nodes"):
        # A plain node has the name of its manager, and is asked for by its key.
        is_plain = bool(node["key"]) and node["name"] == node["program"]
        name = node["key"] if is_plain else node["name"]
        rows.append(NodeRow((name, pid), node["program"], node["lifecycle"]))
    return rows
