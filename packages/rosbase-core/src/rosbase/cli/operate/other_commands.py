"""The commands of plugins, for the completion of shells: it loads the plugins."""

import argparse

from rosbase.plugins import installed_plugins

__all__ = ["commands", "options"]


def commands() -> dict[str, str]:
    """Return the names of all commands, with their summaries."""
    return {name: command.summary for name, command in installed_plugins().commands.items()}


def options(name: str) -> list[tuple[str, str]]:
    """Return the options of a command, the long form of each, with their help."""
    parser = argparse.ArgumentParser()
    installed_plugins().command(name).configure(parser)
    return [
        (action.option_strings[-1], action.help or "")
        for action in parser._actions
        if action.option_strings
    ]
