"""`rosbase plugins`: which plugins are installed, what they bring, and which of them failed."""

import argparse

from rosbase.plugins import PluginRecord, installed_plugins

__all__ = ["configure", "run"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Adds the arguments: there are none."""


def run(arguments: argparse.Namespace) -> int:
    """Prints one line for each plugin."""
    plugins = installed_plugins().plugins
    width = max((len(record.name) for record in plugins), default=0)
    for record in plugins:
        status = "failed" if record.failure else "active"
        origin = f"{record.distribution} {record.version}"
        print(f"{record.name:{width}}  {status}  {origin}  {_what(record)}")
    return 0


def _what(record: PluginRecord) -> str:
    if record.failure:
        return record.failure
    brought: dict[str, list[str]] = {}
    for descriptor in record.descriptors:
        brought.setdefault(descriptor.kind, []).append(descriptor.name)
    return "; ".join(f"{kind}: {', '.join(names)}" for kind, names in brought.items()) or "nothing"
