"""Units of payloads, and the factor to the SI unit of each quantity (REP-103)."""

import math

__all__ = ["STANDARD_GRAVITY", "UNITS"]

STANDARD_GRAVITY = 9.80665
"""Standard gravity in m/s^2; the exact value of one g (3rd CGPM, 1901)."""

UNITS: dict[str, dict[str, float]] = {
    "angular_velocity": {"rad/s": 1.0, "mrad/s": 1e-3, "deg/s": math.pi / 180.0},
    "linear_acceleration": {
        "m/s^2": 1.0,
        "g": STANDARD_GRAVITY,
        "mg": STANDARD_GRAVITY * 1e-3,
    },
    "magnetic_field": {"T": 1.0, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7},
}
"""Factors from units by name to the SI unit (rad/s, m/s^2, T), by quantity."""
