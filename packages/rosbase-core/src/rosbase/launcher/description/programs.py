"""One program of a file, from its mapping."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from rosbase.launcher.description.conditions import read_conditions
from rosbase.launcher.description.cpus import read_cpus
from rosbase.launcher.description.fields import Fields
from rosbase.launcher.description.model import Condition, Program
from rosbase.launcher.description.outside import objection_to
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
    if not name:
        fields.fault("name", f"{what} has an empty name")
    elif not (_NAME.fullmatch(name) and name.isprintable()):
        fields.fault("name", f"the name {name!r} has blanks, or one of / : , or begins with -")
    policy = _restart(fields, faults)
    folder = fields.path("project", workspace)
    files, parameters = _parameters(fields, folder, faults)
    after, lines = _after(fields, faults)
    return Program(
        name=name,
        key=name,
        session=session,
        folder=folder,
        commands=_commands(fields, what, faults),
        autostart=fields.flag("autostart", default=True),
        cpus=_cpus(fields),
        environment=_environment(fields, faults),
        restart=policy,
        after=after,
        after_timeout_s=fields.number("after_timeout_s", None),
        stop_timeout_s=fields.number("stop_timeout_s", None),
        is_required=fields.flag("required", default=False),
        parameters=parameters,
        parameter_files=files,
        backend=fields.text("backend"),
        on_a_terminal=fields.flag("pty", default=False),
        lines={**fields.lines(), **lines},
    )


def _commands(fields: Fields, what: str, faults: Faults) -> tuple[str, ...]:
    value = fields.value("command")
    if value is None:
        fields.fault("command", f"{what} has no command")
        return ()
    if not isinstance(value.data, list):
        if value.is_scalar and not value.text.strip():
            fields.fault("command", f"{what} has an empty command")
        return (fields.text("command"),)
    if not value.data:
        fields.fault("command", f"{what} has an empty list of commands")
    commands = []
    for item in value.data:
        if not item.is_scalar or not item.text.strip():
            faults.add(item.line, "command is a text, or a list of texts that are not empty")
        elif objection := objection_to(item.text):
            faults.add(item.line, f"command {objection}")
        else:
            commands.append(item.text)
    return tuple(commands)


def _cpus(fields: Fields) -> tuple[int, ...]:
    value = fields.value("cpus")
    if value is None:
        return ()
    if isinstance(value.data, list) and all(item.is_scalar for item in value.data):
        if not value.data:
            return ()
        text = ",".join(item.text for item in value.data)
    elif value.is_scalar:
        text = value.text
    else:
        fields.text("cpus")
        return ()
    try:
        return read_cpus(text)
    except ValueError:
        fields.fault("cpus", f"cpus is a list such as 7, 4-5 or 0,2, not {printable(text)!r}")
        return ()


def _environment(fields: Fields, faults: Faults) -> dict[str, str]:
    variables = fields.texts_by_name("env", "a mapping of environment variables")
    value = fields.value("env")
    for name in variables:
        if value is not None and not _VARIABLE.fullmatch(name):
            line = value.data[name].line
            faults.add(line, f"env: {printable(name)!r} is no environment variable")
    return {name: text for name, text in variables.items() if _VARIABLE.fullmatch(name)}


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


def _after(fields: Fields, faults: Faults) -> tuple[dict[str, Condition], dict[str, int]]:
    """Return the conditions, and their lines by `after NAME`."""
    value = fields.value("after")
    found: dict[str, Condition] = {}
    lines: dict[str, int] = {}
    for name, condition, line in () if value is None else read_conditions(value, faults):
        if name in found:
            faults.add(line, f"after has '{printable(name)}' twice")
        found[name] = condition
        lines[f"after {name}"] = line
    return found, lines


def _parameters(
    fields: Fields, folder: Path, faults: Faults
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
    return tuple(folder / fields.at_home("parameters", item.text) for item in items), ()


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
