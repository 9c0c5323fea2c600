"""Run a program in this process: `python -m rosbase.program app.py` or `module:Manager`."""

import runpy
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rosbase.errors import (
    ConfigurationError,
    GivenParameterError,
    NotInstalledError,
    RecordingError,
)
from rosbase.manager import BaseManager
from rosbase.roles.node import BaseNode
from rosbase.text.printable import MOST_LINE, one_line

__all__ = ["main"]


class _NoProgramError(ConfigurationError):
    """The command line names something that cannot be run."""


def main() -> None:
    """Run the program that the command line names; a usage error is one line and status 2.

    An error of the program itself is a traceback, as without this command.
    """
    target = sys.argv[1]
    del sys.argv[0]
    try:
        _run(target)
    except (_NoProgramError, GivenParameterError, NotInstalledError, RecordingError) as error:
        print(f"rosbase run: {one_line(str(error), MOST_LINE)}", file=sys.stderr)
        sys.exit(2)


def _run(target: str) -> None:
    path = Path(target)
    if path.is_dir() and (path / "__main__.py").is_file():
        runpy.run_path(target, run_name="__main__")
        return
    if target.endswith(".py") or "/" in target or path.is_file():
        if not path.is_file():
            raise _NoProgramError(f"{target}: no such file")
        sys.path[0] = str(Path(target).resolve().parent)
        runpy.run_path(target, run_name="__main__")
        return
    module, _, name = target.partition(":")
    if not name:
        _find(module)
        runpy.run_module(module, run_name="__main__", alter_sys=True)
        return
    start(_named(module, name), target)


def start(program: Any, target: str) -> None:
    """Start a manager or standalone node by its class, or end with what a function returns.

    Raises:
        _NoProgramError: It is something else.
    """
    if isinstance(program, type) and issubclass(program, BaseManager):
        program().start_main_loop_timer()
    elif isinstance(program, type) and issubclass(program, BaseNode):
        program().start_spin_standalone()
    elif callable(program) and not isinstance(program, type):
        sys.exit(program())
    else:
        raise _NoProgramError(f"{target} is neither a manager nor a node nor a function")


def _named(module: str, name: str) -> Any:
    _find(module)
    found: Any = import_module(module)
    for part in name.split("."):
        if not hasattr(found, part):
            raise _NoProgramError(f"{module} has no {name}")
        found = getattr(found, part)
    return found


def _find(module: str) -> None:
    """Check that a module exists; the working directory counts.

    Raises:
        _NoProgramError: It does not exist.
    """
    try:
        found = find_spec(module) if all(module.split(".")) else None
    except ModuleNotFoundError as error:
        if not f"{module}.".startswith(f"{error.name}."):
            # Something else, that the package imports.
            raise
        found = None
    except ValueError:
        found = None
    if found is None:
        raise _NoProgramError(f"there is no file or module {module!r}")


if __name__ == "__main__":
    main()
