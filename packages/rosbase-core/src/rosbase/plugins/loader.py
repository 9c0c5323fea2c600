"""Load each plugin separately: a broken one is recorded with the reason, and harms no other.

pluggy's own loader stops at the first import error, lets misspelt hooks pass in silence, and lets
one raising hook discard everyone's results. So this module imports, checks and asks plugins one at
a time.
"""

import inspect
import sys
from collections.abc import Callable, Iterable
from contextlib import redirect_stdout
from types import ModuleType
from typing import Any, TypeAlias

import pluggy
from attrs import evolve, frozen

from rosbase.errors import PluginError
from rosbase.plugins import hookspec
from rosbase.plugins.descriptors import (
    BackendPlugin,
    CheckPlugin,
    CommandPlugin,
    ConversionPlugin,
    Descriptor,
    PresetPlugin,
    RecorderPlugin,
    TransportPlugin,
)
from rosbase.plugins.discovery import Candidate
from rosbase.text.printable import one_line

__all__ = ["PluginRecord", "Trace", "load_plugin", "words_of"]

Trace: TypeAlias = Callable[[str], object]
"""Function that takes one line about a plugin."""

_HOOKS: dict[str, type[Descriptor]] = {
    "rosbase_backends": BackendPlugin,
    "rosbase_transports": TransportPlugin,
    "rosbase_presets": PresetPlugin,
    "rosbase_commands": CommandPlugin,
    "rosbase_conversions": ConversionPlugin,
    "rosbase_checks": CheckPlugin,
    "rosbase_recorders": RecorderPlugin,
}


@frozen
class PluginRecord:
    """Result of loading one entry point."""

    candidate: Candidate
    descriptors: tuple[Descriptor, ...] = ()
    """Descriptors that it registered; none if it failed or is blocked."""
    failure: str = ""
    """Reason of a failure, in one line; empty if it did not fail."""
    is_blocked: bool = False
    """Whether the user has blocked it; then it has not been imported."""

    @property
    def name(self) -> str:
        """Name of the entry point, as users type it."""
        return self.candidate.name

    @property
    def distribution(self) -> str:
        """Installed package that it belongs to."""
        return self.candidate.distribution

    @property
    def version(self) -> str:
        """Version of the package."""
        return self.candidate.version

    @property
    def full_name(self) -> str:
        """Distribution and entry point: two packages may use the same name."""
        return self.candidate.full_name

    @property
    def status(self) -> str:
        """`active`, `blocked` or `failed`."""
        return "blocked" if self.is_blocked else "failed" if self.failure else "active"


def load_plugin(manager: pluggy.PluginManager, candidate: Candidate, trace: Trace) -> PluginRecord:
    """Import the plugin, register it with pluggy, and ask it for its descriptors.

    Every error ends up in the record, and the plugin is unregistered.

    Args:
        manager: Keeps the plugins.
        candidate: The plugin.
        trace: Receives the results of each hook, and the errors.
    """
    record = PluginRecord(candidate)
    if candidate.entry is None:
        return evolve(record, failure=candidate.damage)
    try:
        # What a plugin prints must not stand among what the command prints.
        with redirect_stdout(sys.stderr):
            module = candidate.entry.load()
            descriptors = _register(manager, record.full_name, module, trace)
    except KeyboardInterrupt:
        raise
    except BaseException as error:
        # Base: a module may do anything while it is imported, such as calling sys.exit().
        trace(f"failed: {words_of(error)}")
        return evolve(record, failure=words_of(error))
    return evolve(record, descriptors=tuple(descriptors))


def _register(
    manager: pluggy.PluginManager, name: str, module: ModuleType, trace: Trace
) -> list[Descriptor]:
    _refuse_unmarked_hooks(module)
    try:
        manager.register(module, name=name)
        manager.check_pending()
        return list(_ask(manager, module, trace))
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


def _ask(manager: pluggy.PluginManager, module: ModuleType, trace: Trace) -> Iterable[Descriptor]:
    others = [plugin for plugin in manager.get_plugins() if plugin is not module]
    for hook, expected in _HOOKS.items():
        caller = manager.subset_hook_caller(hook, others)
        if caller.get_hookimpls():
            trace(f"{hook} is called")
            answers = caller()
            if len(answers) < len(caller.get_hookimpls()):
                # pluggy leaves them out.
                raise PluginError(f"{hook} gave None: does it yield or return what it brings?")
            yield from _checked(hook, expected, answers, trace)


def _checked(
    hook: str, expected: type[Descriptor], answers: list[Iterable[Any]], trace: Trace
) -> Iterable[Descriptor]:
    for descriptor in (descriptor for answer in answers for descriptor in answer):
        if not isinstance(descriptor, expected):
            raise PluginError(
                f"{hook} must yield {expected.__name__}, not {type(descriptor).__name__}"
            )
        trace(f"{hook} gave {descriptor.kind} '{descriptor.name}'")
        yield descriptor


def words_of(error: BaseException) -> str:
    """Return the class and the message of an error, in one line."""
    text = one_line(str(error))
    return f"{type(error).__name__}: {text}" if text else type(error).__name__
