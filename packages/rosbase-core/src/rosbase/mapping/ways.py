"""Parse the paths of a quantity and of time, and check what needs no other quantity."""

from rosbase.errors import MappingError
from rosbase.mapping.dates import TIME_UNITS
from rosbase.mapping.description import Quantity, TimeMapping
from rosbase.mapping.path_text import parse_path
from rosbase.mapping.paths import EACH, Way, variants

__all__ = ["check_time", "quantity_ways", "time_ways"]


def quantity_ways(quantity: Quantity, *, numeric_strings: bool) -> list[tuple[Way, ...]]:
    """Return the ways to the components, in their order, for each alternative.

    Args:
        quantity: The quantity as a user described it.
        numeric_strings: Whether a text that is a number counts as one.

    Raises:
        MappingError: A path is invalid, or there are too few or too many.
    """
    paths = [parse_path(text, numeric_strings=numeric_strings) for text in quantity.paths]
    count = len(quantity.components)
    if quantity.is_whole:
        (lone,) = paths
        paths = [tuple(Way((*way.steps, at), way.sign) for way in lone) for at in range(count)]
    if len(paths) != count:
        takes = f"{count} paths or one" if count > 1 else "one path"
        raise MappingError(f"mapping.{quantity.name}.paths takes {takes}, not {len(paths)}")
    written = quantity.written or quantity.components
    in_order = [paths[written.index(name)] for name in quantity.components]
    return variants(in_order, quantity.name)


def time_ways(time: TimeMapping, *, numeric_strings: bool = False) -> list[tuple[Way, ...]]:
    """Return the ways to the parts of a date, for each alternative.

    Args:
        time: The place of the date as a user described it.
        numeric_strings: Whether a text that is a number counts as one.

    Raises:
        MappingError: A path is invalid, or they have different numbers of alternatives.
    """
    paths = [parse_path(text, numeric_strings=numeric_strings) for text in time.paths]
    return variants(paths, "mapping.time")


def check_time(time: TimeMapping, *, is_batch: bool, is_wanted: bool) -> None:
    """Check the description of time, even if dates are not read.

    Args:
        time: The description.
        is_batch: Whether a message holds several samples.
        is_wanted: Whether dates are read.

    Raises:
        MappingError: A part of it is impossible, or has no effect.
    """
    if len(time.paths) > 2:
        raise MappingError("mapping.time.paths takes one path, or seconds and nanoseconds")
    if len(time.paths) == 1 and time.unit not in TIME_UNITS:
        units = ", ".join(TIME_UNITS)
        raise MappingError(f"mapping.time.unit is one of {units}, not {time.unit!r}")
    if len(time.paths) != 1 and time.unit:
        raise MappingError("mapping.time.unit has no effect without one path of time")
    if time.interval and not is_batch:
        raise MappingError("mapping.time.interval has no effect without [*] in mapping.*.paths")
    if is_wanted and not time.paths:
        raise MappingError("the device's time is wanted, but mapping.time.paths is empty")
    _check_ways(time, is_batch=is_batch, is_wanted=is_wanted)


def _check_ways(time: TimeMapping, *, is_batch: bool, is_wanted: bool) -> None:
    ways = [way for alternative in time_ways(time) for way in alternative]
    if any(way.sign < 0 for way in ways):
        raise MappingError("mapping.time.paths takes no minus")
    each = {EACH in way.steps for way in ways}
    if len(each) == 2 or (is_wanted and True in each and not is_batch):
        raise MappingError("[*] is in all of mapping.time.paths and of the quantities, or none")
    if is_wanted and is_batch and True not in each and not time.interval:
        raise MappingError(
            "one date for several samples: put [*] into mapping.time.paths, or set "
            "mapping.time.interval"
        )
