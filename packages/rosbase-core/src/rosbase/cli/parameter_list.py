"""The parameters of the reader as a table: in groups, the most used first."""

from collections.abc import Iterable, Mapping

from rosbase.cli.arguments import as_text
from rosbase.imu.checks.parameters import CHECK_PARAMETERS
from rosbase.parameters import ParameterSpec, ParameterValue
from rosbase.plugins import TransportPlugin
from rosbase.text.printable import log_line

__all__ = ["parameter_table"]

_MOST_USED = (
    "comm_t",
    "device_path",
    "baudrate",
    "server_address",
    "mqtt_topic",
    "wait_for_device",
    "preset",
    "frame_id",
    "topic_namespace",
    "time_source",
)
_MOST_USED_TITLE, _CHECKS, _OTHERS = "most used", "checks of the samples", "the reader"
_PREFIXES = {"mapping.": "payload mapping"}
_SUFFIXES = {"_stddev": "standard deviations, for the covariances", "_full_scale": _CHECKS}
_WIDTH = 44


def parameter_table(
    specs: Iterable[ParameterSpec],
    transports: Mapping[str, TransportPlugin],
    defaults: Mapping[str, ParameterValue],
) -> list[str]:
    """Return the lines of the table.

    Args:
        specs: All parameters.
        transports: Transports with parameters among them, by name.
        defaults: Values that replace the defaults of the specs.
    """
    by_name = {spec.name: spec for spec in specs}
    owners = _owners(transports)
    groups: dict[str, list[ParameterSpec]] = {_MOST_USED_TITLE: []}
    for name in _MOST_USED:
        if name in by_name:
            groups[_MOST_USED_TITLE].append(by_name.pop(name))
    # In this order.
    for title in (_OTHERS, *dict.fromkeys(owners.values()), _CHECKS):
        groups[title] = []
    for spec in by_name.values():
        groups.setdefault(_group_of(spec.name, owners), []).append(spec)
    lines: list[str] = []
    for title, members in groups.items():
        if members:
            lines += ["", title] if lines else [title]
            lines += [_line(spec, defaults.get(spec.name, spec.default)) for spec in members]
    return lines


def _owners(transports: Mapping[str, TransportPlugin]) -> dict[str, str]:
    """Return the group of each parameter of a transport."""
    users: dict[str, list[str]] = {}
    for name, transport in transports.items():
        for spec in transport.parameters:
            users.setdefault(spec.name, []).append(name)
    return {name: f"transport {', '.join(who)}" for name, who in users.items()}


def _group_of(name: str, owners: Mapping[str, str]) -> str:
    if name in owners:
        return owners[name]
    if name in {spec.name for spec in CHECK_PARAMETERS}:
        return _CHECKS
    for prefix, title in _PREFIXES.items():
        if name.startswith(prefix):
            return title
    return next((title for end, title in _SUFFIXES.items() if name.endswith(end)), _OTHERS)


def _line(spec: ParameterSpec, value: ParameterValue) -> str:
    return log_line(f"  {f'{spec.name}:={as_text(value)}':{_WIDTH}}  {spec.description}")
