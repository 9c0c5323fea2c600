"""Units that payloads come in."""

from collections.abc import Mapping

from rosbase.errors import MappingError

__all__ = ["unit_factor"]


def unit_factor(parameter: str, unit: str, known: Mapping[str, float]) -> float:
    """Return by what a number in `unit` is multiplied to be in the SI unit.

    Args:
        parameter: The name of the parameter that states the unit, for messages.
        unit: The unit, as the user wrote it.
        known: The factor of each unit that the quantity may have.

    Raises:
        MappingError: No unit is given, or none of that quantity is called so.
    """
    if unit in known:
        return known[unit]
    choices = ", ".join(known)
    if not unit:
        raise MappingError(f"{parameter} must be stated: {choices}")
    raise MappingError(f"{parameter} is one of {choices}, not {unit!r}")
