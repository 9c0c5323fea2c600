"""What programs and plugins import from `rosbase`, as tables in Markdown, made from the package."""

import ast
import inspect
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import rosbase
from generators.capabilities import table

__all__ = ["GROUPS", "tables"]

GROUPS: dict[str, tuple[str, ...]] = {
    "Roles": ("roles", "manager", "lifecycle"),
    "Messages": ("messages",),
    "Child processes": ("processes",),
    "Launching programs": ("launcher",),
    "Quality of service": ("qos",),
    "Parameters": ("parameters", "contracts.parameter_store"),
    "The IMU reader": ("imu",),
    "Payload mappings": ("mapping",),
    "Plugins": ("plugins",),
    "Transports": ("contracts.transport", "contracts.stamper", "device", "framing"),
    "Recordings": ("contracts.recording",),
    "Arguments of a program": ("program",),
    "Backends": (
        "contracts.backend",
        "contracts.node_connection",
        "contracts.names",
        "contracts.service",
        "contracts.tap",
        "contracts.graph",
        "contracts.new_ends",
        "contracts.message_format",
        "local",
    ),
    "Checks of `rosbase doctor`": ("contracts.checks",),
    "Time, waiting, logging": ("clock", "runtime", "logger"),
    "Text from outside": ("text",),
    "Errors": ("errors",),
}
"""By heading: the modules, below `rosbase`, that define the names."""


def tables() -> str:
    """A table of names for each group. No name of `rosbase.__all__` is left out."""
    homes = {name: _home(name) for name in rosbase.__all__}
    parts = []
    for title, modules in GROUPS.items():
        prefixes = tuple(f"rosbase.{module}" for module in modules)
        names = [name for name, home in homes.items() if home.startswith(prefixes)]
        rows = [[f"{{py:obj}}`rosbase.{name}`", _summary(name, homes.pop(name))] for name in names]
        parts.append(f"## {title}\n\n{table(['name', 'what it is'], rows)}")
    if homes:
        raise ValueError(f"public names that no group shows: {', '.join(homes)}")
    return "\n".join(parts)


def _home(name: str) -> str:
    """The module that defines a name, or the package that offers it."""
    for node in ast.walk(ast.parse(Path(rosbase.__file__).read_text())):
        if isinstance(node, ast.ImportFrom) and name in [alias.name for alias in node.names]:
            return str(node.module)
    raise ValueError(f"rosbase does not import {name}")


def _summary(name: str, home: str) -> str:
    found = getattr(rosbase, name)
    if inspect.isclass(found) or inspect.isfunction(getattr(found, "__wrapped__", found)):
        return (inspect.getdoc(found) or "").partition("\n")[0]
    return _documented(name, home)


def _documented(name: str, home: str) -> str:
    """The first line of what stands below a constant or an alias; empty if nothing does."""
    module = import_module(home)
    for source in (module, *(value for value in vars(module).values() if inspect.ismodule(value))):
        if not source.__name__.startswith(home):
            continue
        body = ast.parse(inspect.getsource(source)).body
        for statement, after in pairwise(body):
            is_it = isinstance(statement, (ast.Assign, ast.AnnAssign)) and name in ast.unparse(
                statement
            ).partition("=")[0].replace(":", " ").split(" ")
            if is_it and isinstance(after, ast.Expr) and isinstance(after.value, ast.Constant):
                return str(after.value.value).partition("\n")[0]
    return ""
