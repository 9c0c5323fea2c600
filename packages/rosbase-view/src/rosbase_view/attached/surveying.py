"""Ask all programs what they have: one round of questions, and the survey that it gives."""

from collections.abc import Mapping, Sequence
from typing import Any

from rosbase import ControlError
from rosbase.control.buses import buses
from rosbase.control.folder import is_alive, sockets
from rosbase.control.gathering import Replies, gather
from rosbase.control.joined_topics import joined_topics
from rosbase.control.questions.base import label
from rosbase.control.shapes import Process, Topic
from rosbase.control.time_limit import TimeLimit
from rosbase_view.attached.choosing import chosen
from rosbase_view.reports import NodeRow, Survey, TopicKey

__all__ = ["Surveyor"]

_ASKS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("process", {}),
    ("topic.list", {}),
    ("node.list", {}),
    ("statistics", {}),
)


class Surveyor:
    """Asks all programs, or one and its child processes.

    A program that does not answer is still there as long as its socket and its process are: its
    last answers count on, and the survey names it.
    """

    def __init__(self, name: str | None) -> None:
        """Begin with nothing known.

        Args:
            name: A program or its pid; None for all.
        """
        self._name = name
        # Of the program with the name, when it was seen last.
        self._pid: int | None = None
        # By socket: two processes may have one pid, each in a namespace of its own.
        self._last: dict[str, Replies] = {}
        # Such programs are left out for five seconds.
        self._silent_until: dict[str, TimeLimit] = {}

    def survey(self) -> Survey:
        """Return what runs now. Takes a second if a program does not answer.

        Raises:
            ControlError: No program has the name, or several have.
        """
        replies = gather(_ASKS, 1.0, None, None, self._silent_until)
        answered = {reply.path: reply for reply in replies}
        silent = {path: pid for path, pid in self._silent().items() if path not in answered}
        kept = {path: self._last[path] for path in silent if path in self._last}
        strange = [pid for path, pid in silent.items() if path not in kept]
        self._last = answered | kept
        answers = {
            reply.pid: reply.answers
            for reply in sorted(self._last.values(), key=lambda reply: reply.pid)
        }
        all_processes = [found[0] for found in answers.values() if _is_answer(found[0])]
        processes = self._chosen(all_processes, strange)
        own = {process["pid"]: answers[process["pid"]] for process in processes}
        loops: list[Any] = [{**one, "pid": pid} for pid, one in _each(own, 3, "programs")]
        mute = frozenset(reply.pid for reply in kept.values()) & own.keys()
        trouble = _trouble(
            [process for process in processes if process["pid"] in mute],
            # The user of one program need not know of others.
            strange if self._name is None else [],
        )
        return Survey(processes, _topics(own, processes), _nodes(own), loops, mute, trouble)

    def _chosen(self, processes: Sequence[Process], strange: Sequence[int]) -> Sequence[Process]:
        """Return the processes that are looked at.

        Args:
            processes: All whose names are known.
            strange: Pids of others.

        Raises:
            ControlError: No program has the name, or several have from the first time on.
        """
        try:
            found = chosen(processes, self._name)
        except ControlError as error:
            if error.kind == "ambiguous" and self._pid in [one["pid"] for one in processes]:
                # Another one of that name has come.
                return chosen(processes, str(self._pid))
            if error.kind == "unknown" and self._pid is not None:
                # The user has named no other program, and the name is right.
                text = f"program {self._name} has ended; waiting until it runs again"
                raise ControlError(text, error.kind) from None
            if error.kind == "unknown" and strange:
                # It may be one of those whose names are not known.
                text = f"{error} ({_trouble([], strange)})"
                raise ControlError(text, error.kind, error.suggestions) from None
            raise
        if self._name is not None:
            self._pid = found[0]["pid"]
        return found

    def ask_again(self, pid: int) -> None:
        """Leave a program out no longer, because it has sent something. Any thread may tell."""
        for path, reply in list(self._last.items()):
            if reply.pid == pid:
                self._silent_until.pop(path, None)

    def _silent(self) -> dict[str, int]:
        """Return the sockets and pids of processes that exist, and have not answered."""
        return {
            path: pid
            for pid, path in sockets()
            if (limit := self._silent_until.get(path)) is not None
            and not limit.is_over
            and is_alive(pid)
        }


def _trouble(known: Sequence[Process], strange: Sequence[int]) -> str:
    """Return a line about processes that do not answer, some of which never have."""
    names = [*map(label, known), *(f"process {pid}" for pid in strange)]
    return f"no answer from {', '.join(names)}" if names else ""


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
