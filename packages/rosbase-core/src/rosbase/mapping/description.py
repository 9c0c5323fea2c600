"""The description of a payload, as users and presets write it."""

from collections.abc import Callable

from attrs import frozen

from rosbase.mapping.quantities import Numbers
from rosbase.mapping.rejects import Reject

__all__ = ["LARGEST", "Quantity", "TimeMapping"]

LARGEST = 1e9
"""A number far beyond any measurement, in any SI unit."""


@frozen
class Quantity:
    """A quantity of a payload, such as a vector, and the places of its components."""

    name: str
    paths: tuple[str, ...] = ()
    """A path for each component, or one to a list of them; none if the device has none."""
    components: tuple[str, ...] = ("x", "y", "z")
    """The components in the order in which a sample has them."""
    written: tuple[str, ...] = ()
    """The order in which the paths, or the list, give them; the same unless stated."""
    factor: float = 1.0
    """The factor from the payload's unit to the SI unit."""
    largest: float = LARGEST
    """The largest absolute value of a component, in the SI unit."""
    required: bool = False
    """Whether a sample without it is refused."""
    finish: Callable[[Numbers], Numbers | Reject] | None = None
    """A function that checks, and may correct, the components together."""

    @property
    def is_whole(self) -> bool:
        """Whether one path leads to a list of all components."""
        return len(self.paths) == 1 and len(self.components) > 1


@frozen
class TimeMapping:
    """The place and unit of a sample's date, and the interval between samples of a message."""

    paths: tuple[str, ...] = ()
    """A path to a number or an ISO 8601 text, or two: to the seconds and to the nanoseconds."""
    unit: str = ""
    """The unit of a single number: `s`, `ms`, `us` or `ns`."""
    interval: str = ""
    """The time between two samples of one message, such as `5 ms` or `rate Hz`."""
