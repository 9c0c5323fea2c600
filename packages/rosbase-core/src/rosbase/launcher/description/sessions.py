"""A whole description, from the tree of a file: sessions, and the programs within."""

import re
from collections import Counter
from pathlib import Path

from attrs import evolve

from rosbase.launcher.description.fields import Fields
from rosbase.launcher.description.model import Condition, Description, Program, Session
from rosbase.launcher.description.order import circles
from rosbase.launcher.description.programs import read_program
from rosbase.launcher.description.tree import Faults, Value
from rosbase.parameters.checking import did_you_mean
from rosbase.text.printable import printable

__all__ = ["ENV_KEYS", "read_description"]

_SESSION_KEYS = ("env", "nodes")
ENV_KEYS = ("session_name", "workspace_root", "ros_setup", "conda_env")
"""Keys of the `env` of a session."""
_EXTRA = "x-"
# A window of tmux is called session:window.pane, `$1` is a session by its number, and a shell reads
# the name in `tmux attach -t NAME`.
_NOT_OF_TMUX = re.compile(r"[^\w-]")


def read_description(tree: Value, folder: Path, stem: str, faults: Faults) -> Description:
    """Return the description, after noting every mistake in it.

    Args:
        tree: The whole file: a list of sessions, or one session at the root.
        folder: Folder of the file; a relative workspace is in it.
        stem: Name of a session that has none.
        faults: Where mistakes are noted.
    """
    sessions = _sessions(tree, folder, stem, faults)
    for name, number in Counter(session.name for session in sessions).items():
        if number > 1:
            line = [s.lines.get("session_name", 0) for s in sessions if s.name == name][-1]
            faults.add(line, f"{number} sessions are called '{printable(name)}'")
    return _connected(Description(tuple(sessions), faults.file), faults)


def _sessions(tree: Value, folder: Path, stem: str, faults: Faults) -> list[Session]:
    if not (isinstance(tree.data, dict) and "sessions" in tree.data):
        return [_session(tree, folder, stem, "the file", faults)]
    fields = Fields(_without_extras(tree), "a file with sessions", ("sessions",), faults)
    found = fields.items("sessions", "a list of sessions")
    if not found and isinstance((value := tree.data["sessions"]).data, (list, type(None))):
        faults.add(value.line, "the list of sessions is empty")
    names = [stem] + [f"{stem}{number}" for number in range(2, len(found) + 1)]
    return [
        _session(value, folder, name, f"session {number}", faults)
        for number, (value, name) in enumerate(zip(found, names, strict=False), 1)
    ]


def _without_extras(value: Value) -> Value:
    """Return a mapping without the keys for the user's own things, such as anchors of YAML."""
    if not isinstance(value.data, dict):
        return value
    own = {key: item for key, item in value.data.items() if not key.startswith(_EXTRA)}
    return Value(own, value.line)


def _session(value: Value, folder: Path, stem: str, what: str, faults: Faults) -> Session:
    fields = Fields(_without_extras(value), what, _SESSION_KEYS, faults)
    env = Fields(fields.value("env") or Value({}, fields.line), "env", ENV_KEYS, faults)
    name = _NOT_OF_TMUX.sub("_", env.text("session_name") or stem)
    workspace = env.path("workspace_root", folder)
    nodes = fields.items("nodes", "a list of programs")
    if isinstance(value.data, dict) and "nodes" not in fields:
        faults.add(fields.line_of("nodes"), f"{what} has no nodes")
    programs = [
        read_program(node, name, workspace, number, faults) for number, node in enumerate(nodes, 1)
    ]
    seen: dict[str, int] = {}
    for program in programs:
        line = program.lines.get("name", program.lines[""])
        if program.name in seen:
            where = f" (line {seen[program.name]})" if seen[program.name] else ""
            faults.add(line, f"two programs are called '{printable(program.name)}'{where}")
        seen.setdefault(program.name, line)
    return Session(
        name=name,
        workspace=workspace,
        programs=tuple(programs),
        ros_setup=env.path("ros_setup", folder) if env.text("ros_setup") else None,
        conda_env=env.text("conda_env"),
        lines={**fields.lines(), **{k: line for k, line in env.lines().items() if k}},
    )


def _connected(description: Description, faults: Faults) -> Description:
    """Give each program its key, and find the programs that `after` names."""
    several = Counter(name for s in description.sessions for name in {p.name for p in s.programs})
    keyed = [
        evolve(
            session,
            programs=tuple(
                evolve(p, key=p.name if several[p.name] == 1 else f"{session.name}/{p.name}")
                for p in session.programs
            ),
        )
        for session in description.sessions
    ]
    everybody = [program for session in keyed for program in session.programs]
    sessions = tuple(
        evolve(
            session,
            programs=tuple(
                evolve(program, after=_resolved(program, session, everybody, faults))
                for program in session.programs
            ),
        )
        for session in keyed
    )
    connected = evolve(description, sessions=sessions)
    _refuse_circles(connected, faults)
    return connected


def _resolved(
    program: Program, session: Session, everybody: list[Program], faults: Faults
) -> dict[str, Condition]:
    found = {}
    own = {one.name: one.key for one in session.programs}
    keys = {one.key: one.key for one in everybody} | own
    for name, condition in program.after.items():
        line = program.lines.get(f"after {name}", 0)
        if name in keys:
            found[keys[name]] = condition
        elif not any(one.name == name for one in everybody):
            hint = did_you_mean(name, keys)
            faults.add(line, f"after: no program is called '{printable(name)}'{hint}")
        else:
            longer = ", ".join(one.key for one in everybody if one.name == name)
            faults.add(line, f"after: '{printable(name)}' may be {longer}")
    return found


def _refuse_circles(description: Description, faults: Faults) -> None:
    programs = {program.key: program for program in description.programs}
    for circle in circles({key: list(program.after) for key, program in programs.items()}):
        lines = programs[circle[0]].lines
        waits_for = programs[circle[1 % len(circle)]]
        names = (waits_for.key, waits_for.name, "")
        line = next((lines[f"after {n}"] for n in names if f"after {n}" in lines), 0)
        if len(circle) == 1:
            faults.add(line, f"'{circle[0]}' waits for itself")
        else:
            faults.add(
                line, f"programs wait for each other: {' after '.join([*circle, circle[0]])}"
            )
