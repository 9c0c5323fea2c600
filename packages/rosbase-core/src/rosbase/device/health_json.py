"""The health of a transport as JSON. Pure."""

from typing import cast

import attrs

from rosbase.contracts.transport import TransportHealth, TransportState
from rosbase.entries.payloads import Json

__all__ = ["health_from_json", "health_to_json"]

_NAMES = tuple(field.name for field in attrs.fields(TransportHealth))


def health_to_json(health: TransportHealth) -> Json:
    """Return the health as JSON."""
    values = {name: getattr(health, name) for name in _NAMES}
    values["state"] = health.state.value
    for name in ("frame_errors", "link_errors"):
        values[name] = dict(values[name])
    return values


def health_from_json(value: Json) -> TransportHealth:
    """Return the health that `health_to_json` wrote, also an earlier version of it.

    Raises:
        ValueError: It is something else.
    """
    if not isinstance(value, dict):
        raise ValueError(f"this is no health of a transport: {value!r}")
    values = {name: value[name] for name in _NAMES if name in value}
    state = TransportState(values.pop("state", TransportState.CLOSED.value))
    return TransportHealth(state, **cast("dict[str, int]", values))  # type: ignore[arg-type]  # each of its own type
