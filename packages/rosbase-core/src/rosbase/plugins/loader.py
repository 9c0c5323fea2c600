"""Loads each plugin on its own: a broken one is recorded with the reason, and harms nobody.

pluggy's own loader stops at the first import error, lets misspelt hooks pass in silence,
and lets one raising hook discard everyone's results. So plugins are imported, checked and
asked one at a time here.
"""

import inspect
from collections.abc import Callable, Iterable
from types import ModuleType
from typing import Any

import pluggy
from attrs import evolve, frozen

from rosbase.errors import PluginError
from rosbase.plugins import hookspec
from rosbase.plugins.descriptors import (
    BackendPlugin,
    CommandPlugin,
    ConversionPlugin,
    Descriptor,
    PresetPlugin,
    TransportPlugin,
)
from rosbase.plugins.discovery import Candidate

__all__ = ["PluginRecord", "load_plugin", "one_line"]

_HOOKS: dict[str, type[Descriptor]] = {
    "rosbase_backends": BackendPlugin,
    "rosbase_transports": TransportPlugin,
    "rosbase_presets": PresetPlugin,
    "rosbase_commands": CommandPlugin,
    "rosbase_conversions": ConversionPlugin,
}


@frozen
class PluginRecord:
    """What became of one entry point."""

    name: str
    """The entry point's name, which is what a user types."""
    distribution: str
    """The installed package that it belongs to."""
    version: str
    descriptors: tuple[Descriptor, ...] = ()
    """What it registered; nothing if it failed."""
    failure: str = ""
    """Why it failed, in one line; empty if it did not."""

    @property
    def full_name(self) -> str:
        """Distribution and entry point: two packages may use the same name."""
        return f"{self.distribution}:{self.name}"


def load_plugin(manager: pluggy.PluginManager, candidate: Candidate) -> PluginRecord:
    """Imports the plugin, registers it with pluggy, and asks it what it brings.

    Whatever goes wrong ends up in the record, and the plugin is taken out again.
    """
    record = PluginRecord(candidate.name, candidate.distribution, candidate.version)
    if candidate.entry is None:
        return evolve(record, failure=candidate.damage)
    try:
        module = candidate.entry.load()
        descriptors = _register(manager, record.full_name, module)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        # Base: a module may do anything while it is imported, such as calling sys.exit().
        return evolve(record, failure=one_line(error))
    return evolve(record, descriptors=tuple(descriptors))


def _register(manager: pluggy.PluginManager, name: str, module: ModuleType) -> list[Descriptor]:
    _refuse_unmarked_hooks(module)
    try:
        manager.register(module, name=name)
        manager.check_pending()
        return list(_ask(manager, module))
    except BaseException:
        # pluggy keeps half of a plugin whose registration it refused.
        if manager.has_plugin(name):
            manager.unregister(name=name)
        raise


def _refuse_unmarked_hooks(module: ModuleType) -> None:
    for name, value in vars(module).items():
        marked = hasattr(value, f"{hookspec.PROJECT_NAME}_impl")
        if name.startswith(hookspec.HOOK_PREFIX) and inspect.isfunction(value) and not marked:
            raise PluginError(f"{name} is not marked with @hookimpl, so it would never be called")


def _ask(manager: pluggy.PluginManager, module: ModuleType) -> Iterable[Descriptor]:
    others = [plugin for plugin in manager.get_plugins() if plugin is not module]
    for hook, expected in _HOOKS.items():
        caller: Callable[[], list[Any]] = manager.subset_hook_caller(hook, others)
        for answer in caller():
            for descriptor in answer:
                if not isinstance(descriptor, expected):
                    raise PluginError(
                        f"{hook} must yield {expected.__name__}, not {type(descriptor).__name__}"
                    )
                yield descriptor


def one_line(error: BaseException) -> str:
    """The class of an error, and what it says."""
    text = " ".join(str(error).split())
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
