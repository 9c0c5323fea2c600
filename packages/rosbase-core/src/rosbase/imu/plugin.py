"""Register the payload presets of the core."""

from collections.abc import Iterable

from rosbase.imu.presets import PRESETS
from rosbase.plugins import PresetPlugin, hookimpl

__all__ = ["rosbase_presets"]


@hookimpl
def rosbase_presets() -> Iterable[PresetPlugin]:
    """Return the presets of the core."""
    return PRESETS
