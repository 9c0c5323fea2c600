"""The hooks. A plugin implements the ones that it needs, marked with `hookimpl`, in one module.

Each hook is a plural noun, takes nothing, and yields descriptors. It is called once, when plugins
are loaded. So the module must not import a device library or open anything.
"""

from collections.abc import Iterable

import pluggy

from rosbase.plugins.descriptors import (
    BackendPlugin,
    CheckPlugin,
    CommandPlugin,
    ConversionPlugin,
    PresetPlugin,
    RecorderPlugin,
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
    """Yield backends, chosen with `backend=` or `ROSBASE_BACKEND`."""
    return ()


@hookspec
def rosbase_transports() -> Iterable[TransportPlugin]:
    """Yield transports, chosen with the parameter `comm_t`."""
    return ()


@hookspec
def rosbase_presets() -> Iterable[PresetPlugin]:
    """Yield payload presets, chosen with the parameter `preset`."""
    return ()


@hookspec
def rosbase_commands() -> Iterable[CommandPlugin]:
    """Yield subcommands of `rosbase`."""
    return ()


@hookspec
def rosbase_conversions() -> Iterable[ConversionPlugin]:
    """Yield conversions of your own message classes, for backends that convert messages."""
    return ()


@hookspec
def rosbase_checks() -> Iterable[CheckPlugin]:
    """Yield checks of `rosbase doctor`. Import a check's dependencies when it runs."""
    return ()


@hookspec
def rosbase_recorders() -> Iterable[RecorderPlugin]:
    """Yield recorders, chosen with the suffix of a file: `rosbase run --record FILE.mcap`."""
    return ()
