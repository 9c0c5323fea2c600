"""The hooks. A plugin implements those it needs, marked with `hookimpl`, in one module.

Each hook is a plural noun, takes nothing, and yields descriptors. It is called once, when
plugins are loaded; so the module must not import a device library, nor open anything.
"""

from collections.abc import Iterable

import pluggy

from rosbase.plugins.descriptors import (
    BackendPlugin,
    CheckPlugin,
    CommandPlugin,
    ConversionPlugin,
    PresetPlugin,
    TransportPlugin,
)

__all__ = ["HOOK_PREFIX", "PROJECT_NAME", "hookimpl", "hookspec"]

PROJECT_NAME = "rosbase"
HOOK_PREFIX = "rosbase_"

hookspec = pluggy.HookspecMarker(PROJECT_NAME)
hookimpl = pluggy.HookimplMarker(PROJECT_NAME)
"""Marks a plugin's function as the implementation of the hook of the same name."""


@hookspec
def rosbase_backends() -> Iterable[BackendPlugin]:
    """Backends, chosen with `backend=` or `ROSBASE_BACKEND`."""
    return ()


@hookspec
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Transports, chosen with the parameter `comm_t`."""
    return ()


@hookspec
def rosbase_presets() -> Iterable[PresetPlugin]:
    """Payload presets, chosen with the parameter `preset`."""
    return ()


@hookspec
def rosbase_commands() -> Iterable[CommandPlugin]:
    """Subcommands of `rosbase`."""
    return ()


@hookspec
def rosbase_conversions() -> Iterable[ConversionPlugin]:
    """Message classes of your own, for backends that convert messages."""
    return ()


@hookspec
def rosbase_checks() -> Iterable[CheckPlugin]:
    """Checks of `rosbase doctor`. What a check needs is imported when it runs."""
    return ()
