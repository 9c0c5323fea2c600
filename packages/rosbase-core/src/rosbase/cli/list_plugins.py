"""`rosbase plugins`: which plugins are installed, what they bring, and which of them failed."""

import argparse
from collections.abc import Mapping

from rosbase.imu.settings import transport_clashes
from rosbase.plugins import PluginRecord, TransportPlugin, installed_plugins

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments: there are none."""


def run(arguments: argparse.Namespace) -> int:
    """Prints one line for each plugin."""
    registry = installed_plugins()
    clashes = transport_clashes(registry)
    width = max((len(record.name) for record in registry.plugins), default=0)
    for record in registry.plugins:
        failure = record.failure or _clash(record, clashes)
        status = "failed" if failure else "active"
        origin = f"{record.distribution} {record.version}"
        print(f"{record.name:{width}}  {status}  {origin}  {failure or _what(record)}")
    return 0


def _clash(record: PluginRecord, clashes: Mapping[str, str]) -> str:
    names = [d.name for d in record.descriptors if d.kind == TransportPlugin.kind]
    return next((clashes[name] for name in names if name in clashes), "")


def _what(record: PluginRecord) -> str:
    brought: dict[str, list[str]] = {}
    for descriptor in record.descriptors:
        brought.setdefault(descriptor.kind, []).append(descriptor.name)
    return "; ".join(f"{kind}: {', '.join(names)}" for kind, names in brought.items()) or "nothing"
