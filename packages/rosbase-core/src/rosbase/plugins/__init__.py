"""Plugins: their descriptors, the hooks that ask for them, and a loader that isolates them."""

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
from rosbase.plugins.hookspec import hookimpl
from rosbase.plugins.loader import PluginRecord
from rosbase.plugins.registry import ENTRY_POINT_GROUP, PluginRegistry, installed_plugins
from rosbase.plugins.switches import BLOCK_VARIABLE

__all__ = [
    "BLOCK_VARIABLE",
    "ENTRY_POINT_GROUP",
    "BackendPlugin",
    "CheckPlugin",
    "CommandPlugin",
    "ConversionPlugin",
    "Descriptor",
    "PluginRecord",
    "PluginRegistry",
    "PresetPlugin",
    "RecorderPlugin",
    "TransportPlugin",
    "hookimpl",
    "installed_plugins",
]
