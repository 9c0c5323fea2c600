"""The parameters of the checks, and the settings made from their values."""

from collections.abc import Callable, Iterable
from typing import Any

from rosbase.imu.checks.checksum import CHECKSUMS, NO_CHECKSUM, compile_checksum
from rosbase.imu.checks.suite import CHECK_MODES, CheckSettings
from rosbase.parameters import ParameterSpec

__all__ = ["CHECK_PARAMETERS", "checks_without_effect", "read_check_settings"]


def _mode(name: str, description: str, *choices: str) -> ParameterSpec:
    return ParameterSpec(name, "warn", description, choices=choices or CHECK_MODES)


CHECK_PARAMETERS: tuple[ParameterSpec, ...] = (
    _mode("plausibility", "what to do when gravity at rest is not 9.81 m/s^2"),
    _mode(
        "gravity_direction", "what to do when gravity at rest is not where the orientation has it"
    ),
    _mode("frozen", "what to do when no number changes, to the last digit"),
    ParameterSpec("frozen_after", 2.0, "seconds after which equal samples are frozen", minimum=0.1),
    _mode(
        "device_clock",
        "when the device's date is far from the arrival: warn, or stamp on arrival",
        "warn",
        "arrival",
        "off",
    ),
    ParameterSpec(
        "device_clock_limit",
        5.0,
        "seconds by which the device's date may differ from the arrival",
        minimum=0.01,
    ),
    ParameterSpec(
        "checksum",
        NO_CHECKSUM,
        "the checksum at the end of each line",
        choices=(NO_CHECKSUM, *CHECKSUMS),
    ),
    ParameterSpec("checksum_separator", "*", "text before the checksum"),
)
"""Check parameters of every reader. `docs/checks.md` explains them."""

_DEFAULTS = {spec.name: spec.default for spec in CHECK_PARAMETERS}


def read_check_settings(get: Callable[[str], Any]) -> CheckSettings:
    """Return the settings from the values of the parameters.

    Raises:
        ParameterError: The separator of the checksum is invalid.
    """
    settings = CheckSettings(
        gravity=get("plausibility"),
        gravity_direction=get("gravity_direction"),
        frozen=get("frozen"),
        frozen_after_s=get("frozen_after"),
        device_clock=get("device_clock"),
        device_clock_limit_s=get("device_clock_limit"),
        checksum=get("checksum"),
        checksum_separator=get("checksum_separator"),
    )
    if settings.checksum != NO_CHECKSUM:
        compile_checksum(settings.checksum, settings.checksum_separator)
    return settings


def checks_without_effect(
    get: Callable[[str], Any],
    *,
    uses_device_time: bool,
    has_orientation: bool,
    has_acceleration: bool,
) -> Iterable[str]:
    """Yield the user settings that have no effect, in a line each."""
    no_dates = "" if uses_device_time else "time_source is arrival"
    is_clock_off = "device_clock is off" if get("device_clock") == "off" else ""
    reasons = {
        "device_clock": no_dates,
        "device_clock_limit": no_dates or is_clock_off,
        "frozen_after": "frozen is off" if get("frozen") == "off" else "",
        "checksum_separator": "checksum is none" if get("checksum") == NO_CHECKSUM else "",
        "plausibility": "" if has_acceleration else "mapping.linear_acceleration.paths is empty",
        "gravity_direction": "" if has_orientation else "mapping.orientation.paths is empty",
    }
    for name, reason in reasons.items():
        if reason and get(name) != _DEFAULTS[name]:
            yield f"{name} has no effect: {reason}"
