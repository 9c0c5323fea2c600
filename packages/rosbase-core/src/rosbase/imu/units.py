"""Units that payloads come in, and the factor to the SI unit of each quantity (REP-103)."""

import math

from rosbase.errors import MappingError

__all__ = ["STANDARD_GRAVITY", "UNITS", "unit_factor"]

STANDARD_GRAVITY = 9.80665
"""m/s^2; the exact value of one g (3rd CGPM, 1901)."""

UNITS: dict[str, dict[str, float]] = {
    "angular_velocity": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": math.pi / 180.0},
    "linear_acceleration": {
        "m/s^2": 1.0,
        "g": STANDARD_GRAVITY,
        "mg": STANDARD_GRAVITY * 1e-3,
    },
    "magnetic_field": {"T": 1.0, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7},
}
"""By quantity: the name of a unit, and how many SI units (rad/s, m/s^2, T) it is."""


def unit_factor(quantity: str, unit: str) -> float:
    """By what a number in `unit` is multiplied to be in the SI unit of its quantity.

    Raises:
        MappingError: No unit is given, or none of that quantity is called so.
    """
    known = UNITS[quantity]
    if unit in known:
        return known[unit]
    choices = ", ".join(known)
    if not unit:
        raise MappingError(f"mapping.{quantity}.unit must be stated: {choices}")
    raise MappingError(f"mapping.{quantity}.unit is one of {choices}, not {unit!r}")
