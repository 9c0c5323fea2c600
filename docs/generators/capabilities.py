"""What the installed plugins declare, as tables in Markdown, made from their descriptors."""

from collections.abc import Mapping
from importlib.metadata import requires

from attrs import fields

from rosbase import (
    BackendPlugin,
    CheckPlugin,
    Descriptor,
    ParameterSpec,
    PluginRegistry,
    PresetPlugin,
    RecorderPlugin,
    TransportPlugin,
)

__all__ = ["table", "tables"]

KINDS: tuple[type[Descriptor], ...] = (
    BackendPlugin,
    TransportPlugin,
    PresetPlugin,
    CheckPlugin,
    RecorderPlugin,
)

# What every plugin has to give, so that there is nothing to compare, and what is shown elsewhere.
LEFT_OUT = {"name", "create", "values", "run", "open", "parameters"}


def tables(registry: PluginRegistry) -> str:
    """A table for each kind of plugin, of the parameters of each transport, and of the wheels."""
    parts = [_kind(registry, kind) for kind in KINDS]
    parts += [_parameters(transport) for transport in registry.transports.values()]
    return "\n".join([*parts, _wheels(registry)])


def _kind(registry: PluginRegistry, kind: type[Descriptor]) -> str:
    declared = [field.name for field in fields(kind) if field.name not in LEFT_OUT]
    head = [kind.kind, *(f"`{name}`" for name in declared), "wheel"]
    if kind is TransportPlugin:
        head.append("which device")
    rows = []
    for record in registry.plugins:
        for found in record.descriptors:
            if isinstance(found, kind):
                row = [f"`{found.name}`", *(_shown(getattr(found, name)) for name in declared)]
                rows.append([*row, record.distribution, *_device(found)])
    return f"## {kind.kind.capitalize()}s\n\n{table(head, sorted(rows))}"


def _device(found: Descriptor) -> list[str]:
    if not isinstance(found, TransportPlugin):
        return []
    return [_shown(next((spec.name for spec in found.parameters), ""))]


def _parameters(transport: TransportPlugin) -> str:
    rows = [
        [f"`{spec.name}`", _shown(spec.default), _values(spec), spec.description]
        for spec in transport.parameters
    ]
    title = f"## Parameters of the transport `{transport.name}`"
    return f"{title}\n\n{table(['parameter', 'default', 'values', 'what it is'], rows)}"


def _wheels(registry: PluginRegistry) -> str:
    versions = {record.distribution: record.version for record in registry.plugins}
    rows = []
    for name, version in versions.items():
        needed = [line for line in requires(name) or [] if "extra ==" not in line]
        rows.append([name, version, ", ".join(f"`{line}`" for line in sorted(needed))])
    return f"## Wheels\n\n{table(['wheel', 'version', 'needs'], rows)}"


def _values(spec: ParameterSpec) -> str:
    if spec.choices:
        return ", ".join(f"`{choice}`" for choice in spec.choices)
    if spec.minimum is not None and spec.maximum is not None:
        return f"{spec.minimum:,} to {spec.maximum:,}"
    return spec.kind.value


def _shown(value: object) -> str:
    match value:
        case None | "" | ():
            return "none"
        case Mapping():
            return ", ".join(f"`{key}`" for key in value) or "none"
        case bool():
            return "yes" if value else "no"
        case str() if " " in value:
            return value
    return "yes" if callable(value) else f"`{value}`"


def table(head: list[str], rows: list[list[str]]) -> str:
    """The rows below their head, in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    # A bar would end the cell.
    cells = ([cell.replace("|", "\\|") for cell in line] for line in lines)
    return "".join(f"| {' | '.join(line)} |\n" for line in cells)
