"""One program of a file, from its mapping."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from rosbase.launcher.description.conditions import read_conditions
from rosbase.launcher.description.cpus import read_cpus
from rosbase.launcher.description.fields import Fields
from rosbase.launcher.description.model import Condition, Program
from rosbase.launcher.description.tree import Faults, Value
from rosbase.parameters.checking import did_you_mean
from rosbase.parameters.given import GivenValue
from rosbase.processes.restart import RestartPolicy, RestartWhen
from rosbase.text.printable import printable

__all__ = ["PROGRAM_KEYS", "RESTART_KEYS", "read_program"]

PROGRAM_KEYS = (
    *("name", "project", "command", "cpus", "autostart", "env", "restart", "required"),
    *("after", "after_timeout_s", "stop_timeout_s", "parameters", "backend", "pty"),
)
"""Keys of a program."""
RESTART_KEYS = ("policy", "limit", "backoff_s", "longest_backoff_s", "stable_s")
"""Keys of `restart`."""
_POLICIES: tuple[RestartWhen, ...] = get_args(RestartWhen)
_NAME = re.compile(r"[^\s/:,-][^\s/:,]*")
_VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*", re.ASCII)


def read_program(
    value: Value, session: str, workspace: Path, number: int, faults: Faults
) -> Program:
    """Return a program, after noting what is wrong with it.

    Args:
        value: Its mapping.
        session: Name of its session.
        workspace: Folder that its project is in.
        number: Its place in the list of the session, from 1.
        faults: Where mistakes are noted.
    """
    named = value.data.get("name") if isinstance(value.data, dict) else None
    shown = printable(named.text) if named is not None else ""
    what = f"program '{shown}'" if shown else f"program {number}"
    fields = Fields(value, what, PROGRAM_KEYS, faults)
    name = fields.text("name", f"program{number}", is_required=isinstance(value.data, dict))
    if shown and not (_NAME.fullmatch(name) and name.isprintable()):
        fields.fault("name", f"the name {name!r} has blanks, or one of / : , or begins with -")
    policy = _restart(fields, faults)
    files, parameters = _parameters(fields, workspace, faults)
    return Program(
        name=name,
        key=name,
        session=session,
        folder=workspace / Path(fields.text("project", ".")).expanduser(),
        commands=_commands(fields, what),
        autostart=fields.flag("autostart", default=True),
        cpus=_cpus(fields),
        environment=_environment(fields),
        restart=policy,
        after=_after(fields, faults),
        after_timeout_s=fields.number("after_timeout_s", None),
        stop_timeout_s=fields.number("stop_timeout_s", None),
        is_required=fields.flag("required", default=False),
        parameters=parameters,
        parameter_files=files,
        backend=fields.text("backend"),
        on_a_terminal=fields.flag("pty", default=False),
        lines=fields.lines(),
    )


def _commands(fields: Fields, what: str) -> tuple[str, ...]:
    value = fields.value("command")
    if value is None:
        fields.fault("command", f"{what} has no command")
        return ()
    if not isinstance(value.data, list):
        text = fields.text("command")
        if not text.strip():
            fields.fault("command", f"{what} has an empty command")
        return (text,)
    commands = [item.text for item in value.data if item.is_scalar]
    if len(commands) < len(value.data) or not all(command.strip() for command in commands):
        fields.fault("command", "command is a text, or a list of texts that are not empty")
    elif not commands:
        fields.fault("command", f"{what} has an empty list of commands")
    return tuple(commands)


def _cpus(fields: Fields) -> tuple[int, ...]:
    value = fields.value("cpus")
    if value is None:
        return ()
    if isinstance(value.data, list) and all(item.is_scalar for item in value.data):
        text = ",".join(item.text for item in value.data)
    else:
        text = fields.text("cpus")
    try:
        return read_cpus(text) if text else ()
    except ValueError:
        fields.fault("cpus", f"cpus is a list such as 7, 4-5 or 0,2, not {printable(text)!r}")
        return ()


def _environment(fields: Fields) -> dict[str, str]:
    variables = fields.texts_by_name("env", "a mapping of environment variables")
    for name, text in variables.items():
        if not _VARIABLE.fullmatch(name) or "\0" in text:
            fields.fault("env", f"env: {printable(name)!r} is no environment variable")
    return variables


def _restart(fields: Fields, faults: Faults) -> RestartPolicy:
    value = fields.value("restart")
    if value is None:
        return RestartPolicy()
    if not isinstance(value.data, dict):
        return RestartPolicy(_policy(fields, "restart", value))
    inner = Fields(value, "restart", RESTART_KEYS, faults)
    usual = RestartPolicy()
    first_s = inner.number("backoff_s", usual.first_delay_s)
    return RestartPolicy(
        _policy(inner, "policy", inner.value("policy")) if "policy" in inner else "on-failure",
        limit=inner.number("limit", usual.limit, is_whole=True),
        first_delay_s=first_s,
        longest_delay_s=inner.number("longest_backoff_s", max(usual.longest_delay_s, first_s)),
        stable_s=inner.number("stable_s", usual.stable_s),
    )


def _policy(fields: Fields, key: str, value: Value | None) -> RestartWhen:
    text = value.text if value is not None else ""
    for policy in _POLICIES:
        if text == policy:
            return policy
    hint = did_you_mean(text, _POLICIES)
    fields.fault(key, f"{key} is one of {', '.join(_POLICIES)}, not {printable(text)!r}{hint}")
    return "never"


def _after(fields: Fields, faults: Faults) -> dict[str, Condition]:
    value = fields.value("after")
    found: dict[str, Condition] = {}
    for name, condition, line in () if value is None else read_conditions(value, faults):
        if name in found:
            faults.add(line, f"after has '{printable(name)}' twice")
        found[name] = condition
    return found


def _parameters(
    fields: Fields, workspace: Path, faults: Faults
) -> tuple[tuple[Path, ...], tuple[GivenValue, ...]]:
    """Return the parameter files and the parameters: a file, files, or values by name."""
    value = fields.value("parameters")
    if value is None:
        return (), ()
    if isinstance(value.data, dict):
        given = tuple(
            GivenValue("", name.removeprefix("/**."), data, "typed")
            for name, data in _flat(value, "", faults)
        )
        return (), given
    items = value.data if isinstance(value.data, list) else [value]
    if not all(isinstance(item.data, str) for item in items):
        fields.fault("parameters", "parameters is a mapping, a file, or a list of files")
        return (), ()
    folder = workspace / Path(fields.text("project", ".")).expanduser()
    return tuple(folder / Path(item.text).expanduser() for item in items), ()


def _flat(value: Value, prefix: str, faults: Faults) -> Iterator[tuple[str, Any]]:
    """Yield parameters by dotted name."""
    for key, item in value.data.items():
        name = f"{prefix}{key}"
        if isinstance(item.data, dict):
            yield from _flat(item, f"{name}.", faults)
        elif isinstance(item.data, list):
            if all(entry.is_scalar for entry in item.data):
                yield name, [entry.data for entry in item.data]
            else:
                faults.add(item.line, f"parameter {printable(name)} is neither a value nor a list")
        elif item.data is None:
            faults.add(item.line, f"parameter {printable(name)} has no value")
        else:
            yield name, item.data
