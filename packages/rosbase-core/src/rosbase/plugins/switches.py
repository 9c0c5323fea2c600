"""Switches for plugins in the environment: which to block, how strict to be, what to print."""

import os
import re
from collections.abc import Iterable

from attrs import frozen

from rosbase.errors import ConfigurationError
from rosbase.logger import RosbaseLogger
from rosbase.plugins.discovery import Candidate

__all__ = ["BLOCK_VARIABLE", "STRICT_VARIABLE", "TRACE_VARIABLE", "PluginSwitches"]

BLOCK_VARIABLE = "ROSBASE_BLOCK_PLUGINS"
"""Variable with the plugins that are not even imported, separated by commas."""

STRICT_VARIABLE = "ROSBASE_STRICT_PLUGINS"
"""Variable that makes a failed plugin an error."""

TRACE_VARIABLE = "ROSBASE_TRACE_HOOKS"
"""Variable that prints the results of each plugin's hooks to stderr."""

_SWITCH = {"": False, "0": False, "false": False, "1": True, "true": True}


@frozen
class PluginSwitches:
    """Switches of a user for the plugins of this process."""

    blocked: tuple[str, ...] = ()
    """Names of plugins, of distributions, or `distribution:name`."""
    is_strict: bool = False
    traces: bool = False

    @classmethod
    def from_environment(cls) -> "PluginSwitches":
        """Return the switches in the three variables.

        Raises:
            ConfigurationError: A switch is neither on nor off.
        """
        names = os.environ.get(BLOCK_VARIABLE, "").split(",")
        return cls(
            tuple(name.strip() for name in names if name.strip()),
            is_strict=_is_on(STRICT_VARIABLE),
            traces=_is_on(TRACE_VARIABLE),
        )

    def choose_blocked(self, candidates: Iterable[Candidate]) -> set[str]:
        """Return the full names of the blocked plugins; a name that matches none is a warning.

        Raises:
            ConfigurationError: A name matches only a part of the core.
        """
        chosen: set[str] = set()
        listed = list(candidates)
        for name in self.blocked:
            meant = [candidate for candidate in listed if _means(name, candidate)]
            others = {candidate.full_name for candidate in meant if not candidate.is_core}
            if meant and not others:
                core = meant[0].distribution
                raise ConfigurationError(
                    f"{BLOCK_VARIABLE}: {name!r} is a part of {core}, which cannot be blocked"
                )
            if not meant:
                RosbaseLogger("plugins").warning(
                    f"{BLOCK_VARIABLE}: no installed plugin is called {name!r}"
                )
            chosen |= others
        return chosen


def _is_on(variable: str) -> bool:
    text = os.environ.get(variable, "")
    if text.lower() not in _SWITCH:
        raise ConfigurationError(f"{variable} is 0, 1, false or true, not {text!r}")
    return _SWITCH[text.lower()]


def _means(name: str, candidate: Candidate) -> bool:
    of_candidate = candidate.name, candidate.distribution, candidate.full_name
    return _plain(name) in map(_plain, of_candidate)


def _plain(name: str) -> str:
    """Normalize a distribution name, where case, `-`, `_` and `.` do not matter (PEP 503)."""
    return re.sub(r"[-_.]+", "-", name).lower()
