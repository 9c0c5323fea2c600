"""Units of the numbers in payloads."""

from collections.abc import Mapping

from rosbase.errors import MappingError

__all__ = ["unit_factor"]


def unit_factor(parameter: str, unit: str, known: Mapping[str, float]) -> float:
    """Return the factor from `unit` to the SI unit.

    Args:
        parameter: The name of the parameter that states the unit, for messages.
        unit: The unit, as the user wrote it.
        known: The factor of each unit that the quantity may have.

    Raises:
        MappingError: The unit is empty or unknown.
    """
    if unit in known:
        return known[unit]
    choices = ", ".join(known)
    if not unit:
        raise MappingError(f"{parameter} must be stated: {choices}")
    raise MappingError(f"{parameter} is one of {choices}, not {unit!r}")
