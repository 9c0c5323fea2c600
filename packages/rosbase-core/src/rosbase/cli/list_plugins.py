"""`rosbase plugins`: list the installed plugins, their parts and their status."""

import argparse

from rosbase.imu.settings import judged_plugins
from rosbase.plugins import BLOCK_VARIABLE, PluginRecord, installed_plugins
from rosbase.text.printable import log_line

__all__ = ["configure", "run", "what_of"]


def configure(parser: argparse.ArgumentParser) -> None:
    """Add no arguments: there are none."""


def run(arguments: argparse.Namespace) -> int:
    """Print one line for each plugin."""
    records = judged_plugins(installed_plugins())
    name_width = max((len(record.name) for record in records), default=0)
    status_width = max((len(record.status) for record in records), default=0)
    for record in records:
        origin = f"{record.distribution} {record.version}"
        states = f"{record.name:{name_width}}  {record.status:{status_width}}"
        print(log_line(f"{states}  {origin}  {what_of(record)}"))
    return 0


def what_of(record: PluginRecord) -> str:
    """Return the parts of a plugin, or why it has none."""
    if record.is_blocked:
        return f"by {BLOCK_VARIABLE}"
    if record.failure:
        return record.failure
    brought: dict[str, list[str]] = {}
    for descriptor in record.descriptors:
        brought.setdefault(descriptor.kind, []).append(descriptor.name)
    return "; ".join(f"{kind}: {', '.join(names)}" for kind, names in brought.items()) or "nothing"
