"""What users and presets say of a payload, as they say it."""

from collections.abc import Callable

from attrs import frozen

from rosbase.mapping.quantities import Numbers
from rosbase.mapping.rejects import Reject

__all__ = ["LARGEST", "Quantity", "TimeMapping"]

LARGEST = 1e9
"""Far beyond what any sensor measures, in any SI unit: such a number is an error."""


@frozen
class Quantity:
    """One quantity of a payload, such as a vector: where its components are."""

    name: str
    paths: tuple[str, ...] = ()
    """A path for each component, or one to a list of them; none if the device has none."""
    components: tuple[str, ...] = ("x", "y", "z")
    """The components in the order in which a sample has them."""
    written: tuple[str, ...] = ()
    """The order in which the paths, or the list, give them; the same unless stated."""
    factor: float = 1.0
    """By what each number is multiplied to be in the SI unit."""
    largest: float = LARGEST
    """The largest absolute value of a component, in the SI unit."""
    required: bool = False
    """Whether there is no sample without it."""
    finish: Callable[[Numbers], Numbers | Reject] | None = None
    """Checks, and perhaps corrects, the components together."""

    @property
    def is_whole(self) -> bool:
        """Whether one path leads to a list of all components."""
        return len(self.paths) == 1 and len(self.components) > 1


@frozen
class TimeMapping:
    """Where the date of a sample is, in which unit, and how far apart samples of a message are."""

    paths: tuple[str, ...] = ()
    """A path to a number or an ISO 8601 text, or two: to the seconds and to the nanoseconds."""
    unit: str = ""
    """The unit of a lone number: `s`, `ms`, `us` or `ns`."""
    interval: str = ""
    """The time between two samples of one message, such as `5 ms` or `rate Hz`."""
