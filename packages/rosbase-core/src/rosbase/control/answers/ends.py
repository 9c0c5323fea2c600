"""Find the topics and services of this process, their types, and the backend that has them."""

from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

from rosbase.contracts.backend import Backend
from rosbase.contracts.graph import Graph, ServiceEnd, TopicEnd
from rosbase.contracts.message_format import MessageFormat
from rosbase.control.answers.lookup import chosen_programs
from rosbase.control.programs import Program, running_programs
from rosbase.errors import BackendError, ControlError

__all__ = [
    "FoundTopic",
    "all_graphs",
    "find_class",
    "find_service",
    "find_topic",
    "find_topics",
    "format_facts",
    "format_of",
    "program_for",
    "type_class",
]

_MOST_SHOWN = 200


class FoundTopic(NamedTuple):
    """A topic, with the program at whose backend it is looked at."""

    name: str
    type_name: str
    msg_type: Any
    """Class of the messages; None if it is unknown."""
    program: Program
    backend: Backend


def all_graphs() -> Iterator[tuple[Program, Backend, Graph]]:
    """Yield the graph of each program that has one."""
    for program in running_programs():
        backend = program.backend
        if backend is not None:
            try:
                yield program, backend, backend.graph()
            except BackendError:
                # One of a plugin that has none.
                continue


def find_topic(name: str) -> FoundTopic:
    """Return the topic of a name, with or without its first `/`.

    It is looked at where it is published; if it is not, where it is subscribed to.

    Raises:
        ControlError: There is none.
    """
    known = _all_ends()
    found = known.get(name) or known.get(f"/{name}")
    if not found:
        raise _unknown("topic", name, known)
    return _found(found)


def find_topics(names: Iterable[str]) -> list[FoundTopic]:
    """Return the topics of these names, as `find_topic` does; a name that has none is left out."""
    known = _all_ends()
    return [_found(known[name]) for name in names if name in known]


_Ends = list[tuple[bool, Program, Backend, TopicEnd]]


def _all_ends() -> dict[str, _Ends]:
    """Return the ends of each topic, with whether they are subscriptions."""
    known: dict[str, _Ends] = {}
    for program, backend, graph in all_graphs():
        for ends in (graph.publishers, graph.subscriptions):
            for end in ends:
                found = (ends is graph.subscriptions, program, backend, end)
                known.setdefault(end.name, []).append(found)
    return known


def _found(ends: _Ends) -> FoundTopic:
    # Not the first by chance: another one may know the class.
    _, program, backend, end = min(ends, key=lambda one: one[0])
    kinds = [one[3].msg_type for one in ends if one[2] is backend]
    kind = next((kind for kind in kinds if kind is not None), None)
    return FoundTopic(end.name, end.type_name, kind, program, backend)


def find_service(name: str) -> tuple[Program, Backend, ServiceEnd]:
    """Return the service of a name, with or without its first `/`.

    Raises:
        ControlError: There is none.
    """
    known: dict[str, None] = {}
    for program, backend, graph in all_graphs():
        for end in graph.services:
            if end.name in (name, f"/{name}"):
                return program, backend, end
            known[end.name] = None
    raise _unknown("service", name, known)


def find_class(type_name: str) -> tuple[Backend, Any]:
    """Return the class of a message or a service, and a backend that knows it.

    Raises:
        ControlError: Nobody knows it.
    """
    backends = [one.backend for one in running_programs() if one.backend is not None]
    for backend in backends:
        try:
            return backend, type_class(backend, type_name)
        except ControlError:
            continue
    raise ControlError(f"there is no type {type_name[:_MOST_SHOWN]!r} here", "unknown")


def type_class(backend: Backend, type_name: str, kind: Any = None) -> Any:
    """Return the class of a type: the one given, one that is used, or one by its name.

    Raises:
        ControlError: The backend knows none.
    """
    if kind is not None:
        return kind
    try:
        graph = backend.graph()
    except BackendError:
        graph = Graph()
    topics, services = (*graph.publishers, *graph.subscriptions), (*graph.services, *graph.clients)
    used = [end.msg_type for end in topics if end.type_name == type_name]
    used += [end.srv_type for end in services if end.type_name == type_name]
    found = next((one for one in used if one is not None), None)
    if found is not None:
        return found
    try:
        return backend.find_type(type_name)
    except TypeError as error:
        raise ControlError(str(error)[:_MOST_SHOWN], "unknown") from None


def format_of(backend: Backend, type_name: str, kind: Any = None) -> MessageFormat:
    """Return the format of a type of messages.

    Raises:
        ControlError: It has none, such as a class of Python without a ROS type.
    """
    try:
        return backend.message_format(type_class(backend, type_name, kind))
    except TypeError as error:
        text = f"{type_name} has no schema: {error}"
        raise ControlError(text[: 2 * _MOST_SHOWN]) from None


def format_facts(form: MessageFormat) -> dict[str, Any]:
    """Return what a client needs to read messages."""
    return {
        "type": form.type_name,
        "encoding": "cdr",
        "schema_encoding": "ros2msg",
        "schema": form.schema,
        "hash": form.type_hash,
    }


def program_for(name: str) -> tuple[Program, Backend]:
    """Return the program of a name, or the first if it is empty, with its backend.

    Raises:
        ControlError: There is none.
    """
    for program in chosen_programs(name):
        if program.backend is not None:
            return program, program.backend
    raise ControlError("no program here has a backend", "refused")


def _unknown(what: str, name: str, known: Iterable[str]) -> ControlError:
    from difflib import get_close_matches

    names = list(known)
    near = get_close_matches(name if name.startswith("/") else f"/{name}", names)
    return ControlError(f"there is no {what} {name[:_MOST_SHOWN]!r}", "unknown", near)
