"""Names of what runs, for the completion of shells. Each function is a kind in `words`."""

from __future__ import annotations

import os

from rosbase.control.questions.base import Questions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    Names = list[tuple[str, str]]

WITH_SLASH = frozenset(("topics", "nodes", "services", "lifecycle_nodes"))
"""Kinds of names whose slash in front may be left out."""

# Only a program that hangs takes so long.
_WAIT_S = 1.0


def topics(_arguments: list[str], program: str | None, _current: str) -> Names:
    """Return the topics, with their types."""
    from rosbase.control.questions.topics import TopicQuestions

    return [(t["name"], ", ".join(t["types"])) for t in TopicQuestions(program, _WAIT_S).topics()]


def topic_type(arguments: list[str], program: str | None, current: str) -> Names:
    """Return the type of the topic that is the first argument."""
    wanted = arguments[0].lstrip("/")
    found = [w for n, w in topics(arguments, program, current) if n.lstrip("/") == wanted]
    return [(name, "") for types in found for name in types.split(", ")]


def services(_arguments: list[str], program: str | None, _current: str) -> Names:
    """Return the services, with their types."""
    from rosbase.control.questions.services import ServiceQuestions

    found = ServiceQuestions(program, _WAIT_S).services()
    return list(dict.fromkeys((s["name"], s["type"]) for s in found if s["servers"]))


def service_type(arguments: list[str], program: str | None, current: str) -> Names:
    """Return the type of the service that is the first argument."""
    wanted = arguments[0].lstrip("/")
    found = services(arguments, program, current)
    return [(kind, "") for name, kind in found if name.lstrip("/") == wanted]


def nodes(_arguments: list[str], program: str | None, _current: str) -> Names:
    """Return the nodes."""
    from rosbase.control.questions.nodes import NodeQuestions

    found = NodeQuestions(program, _WAIT_S).nodes()
    return sorted({(node["name"], "") for node in found})


def parameters(arguments: list[str], program: str | None, _current: str) -> Names:
    """Return the parameters of the node that is the first argument."""
    from rosbase.control.questions.parameters import (
        ParameterQuestions,
    )

    found = ParameterQuestions(program, _WAIT_S).typed_parameters(arguments[0])
    return [(name, f"{one['type']} {one['value']}") for name, one in sorted(found.items())]


def lifecycle_nodes(_arguments: list[str], program: str | None, _current: str) -> Names:
    """Return the lifecycle nodes, with their states."""
    from rosbase.control.questions.lifecycle import LifecycleQuestions

    states = LifecycleQuestions(program, _WAIT_S).lifecycle_states()
    return [(state["name"], state["state"]) for state in states]


def transitions(arguments: list[str], program: str | None, _current: str) -> Names:
    """Return the transitions that the node offers that is the first argument."""
    from rosbase.control.questions.lifecycle import LifecycleQuestions

    found = LifecycleQuestions(program, _WAIT_S).transitions(arguments[0])
    return [(one["label"], f"{one['start']} to {one['goal']}") for one in found]


def programs(_arguments: list[str], _program: str | None, _current: str) -> Names:
    """Return the programs, with their pids."""
    found = Questions(None, _WAIT_S).processes()
    return [
        (program["name"].lstrip("/"), f"process {process['pid']}")
        for process in found
        for program in process["programs"]
    ]


def launched(_arguments: list[str], _program: str | None, _current: str) -> Names:
    """Return the programs that `rosbase up` has started."""
    from rosbase.control.questions.programs import ProgramQuestions

    return [(one["name"], one["state"]) for one in ProgramQuestions(None, _WAIT_S).launched()]


def stoppable(arguments: list[str], program: str | None, current: str) -> Names:
    """Return all programs that can be stopped by name."""
    known: dict[str, Any] = dict(launched(arguments, program, current))
    return list({**dict(programs(arguments, program, current)), **known}.items())


def files(_arguments: list[str], _program: str | None, current: str) -> Names:
    """Return the files and folders whose path begins like the current word."""
    folder, _, beginning = current.rpartition("/")
    place = f"{folder}/" if folder or current.startswith("/") else ""
    found = []
    for entry in os.scandir(os.path.expanduser(place) or "."):
        if entry.name.startswith(beginning) and (beginning or not entry.name.startswith(".")):
            found.append((f"{place}{entry.name}{'/' * entry.is_dir()}", ""))
    return sorted(found)
