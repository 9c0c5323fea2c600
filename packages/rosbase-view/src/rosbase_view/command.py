"""`rosbase view`: look at running programs, or at a recording."""

import argparse
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from rosbase import ConfigurationError
from rosbase_view.options import add_arguments, options_of
from rosbase_view.sources import open_source

__all__ = ["configure", "run"]

# Each has `check(options)`, before anything is opened, and `run(source, options)`.
_VIEWS = {
    "terminal": "rosbase_view.terminal.show",
    "web": "rosbase_view.web.show",
    "foxglove": "rosbase_view.foxglove.show",
}
# Module of each extra, which has the name of the view, and the command that installs it. The
# command works wherever rosbase-view itself came from.
_NEEDS = {
    "web": ("viser", "pip install 'viser>=1.1,<2'"),
    "foxglove": ("foxglove", "pip install 'foxglove-sdk>=0.30,<0.31'"),
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_arguments(parser)


def run(arguments: Any) -> int:
    """Show the view until the user ends it; return the exit status.

    Raises:
        ConfigurationError: There is no terminal, an extra is not installed, or the arguments do
            not go together.
        ControlError: No program has that name, or several have.
    """
    options = options_of(arguments, _mistake)
    if options.view in _NEEDS:
        module, command = _NEEDS[options.view]
        if find_spec(module) is None:
            raise ConfigurationError(f"rosbase view --{options.view} needs {module}: {command}")
    # The libraries of the views take a tenth of a second and more to import.
    view = import_module(_VIEWS[options.view])
    view.check(options)
    # Before a screen changes or a port is opened, so that a wrong name is one line.
    source = open_source(options.name)
    status: int = view.run(source, options)
    return status


def _mistake(text: str) -> None:
    raise ConfigurationError(text)
