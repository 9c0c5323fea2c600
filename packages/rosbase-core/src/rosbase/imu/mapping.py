"""The quantities of an IMU, and the mapping from a device's payload to a sample of them."""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeAlias, cast

from attrs import frozen

from rosbase.errors import MappingError
from rosbase.imu.units import UNITS
from rosbase.mapping.assembly import Batch
from rosbase.mapping.description import Quantity, TimeMapping
from rosbase.mapping.payload_mapping import PayloadMapping
from rosbase.mapping.quaternions import compile_unit_quaternion
from rosbase.mapping.rejects import Reject
from rosbase.mapping.units import unit_factor

__all__ = [
    "FULL_SCALES",
    "GROUPS",
    "MAX_TOLERANCE",
    "VECTORS",
    "ImuMapping",
    "Sample",
    "SampleReader",
]

VECTORS = tuple(UNITS)
GROUPS = ("orientation", *VECTORS)
"""Quantities that a payload may hold."""

MAX_TOLERANCE = 0.5
"""Maximum deviation of a quaternion's norm from 1.

Beyond it the value is something else, such as zero.
"""

FULL_SCALES: dict[str, float] = {
    "angular_velocity": 69.8132,
    "linear_acceleration": 313.8128,
    "magnetic_field": 0.01,
}
"""Limits that no usual chip exceeds, by vector, in SI units: 4,000 deg/s, 32 g and 100 gauss."""

_ORDERS = {"": "xyzw", "xyzw": "xyzw", "wxyz": "wxyz"}


class Sample(NamedTuple):
    """Content of one payload in SI units; None for missing quantities."""

    orientation: tuple[float, ...] | None
    """x, y, z, w of a unit quaternion."""
    angular_velocity: tuple[float, ...] | None
    """x, y, z in rad/s."""
    linear_acceleration: tuple[float, ...] | None
    """x, y, z in m/s^2, gravity included."""
    magnetic_field: tuple[float, ...] | None
    """x, y, z in tesla."""
    device_time_ns: int | None
    """Date of the device in nanoseconds since the epoch, if it was asked for and usable."""
    left_out: tuple[Reject, ...] = ()
    """Reason why a quantity, or the date, is missing although the payload has a part of it."""


SampleReader: TypeAlias = Callable[[bytes], Sample | Reject | Batch[Sample]]
"""Function that makes of a frame one sample, several, or a reason why there is none. Never raises.
"""


@frozen
class ImuMapping:
    """Paths and units of the quantities in a payload. See `docs/mapping.md`.

    Paths are written `a.b`, `list[0].x`, `list[*].x`, `[kind=imu].x`, `-a.z` or `new|old`. One
    path for a whole quantity is a list of its components.
    """

    orientation_paths: tuple[str, ...] = ()
    orientation_order: str = ""
    """Order of the quaternion in the paths or the list: `xyzw`, or `wxyz`."""
    angular_velocity_paths: tuple[str, ...] = ()
    angular_velocity_unit: str = ""
    angular_velocity_full_scale: float = FULL_SCALES["angular_velocity"]
    """Maximum absolute value of a component, in rad/s."""
    linear_acceleration_paths: tuple[str, ...] = ()
    linear_acceleration_unit: str = ""
    linear_acceleration_full_scale: float = FULL_SCALES["linear_acceleration"]
    """Maximum absolute value of a component, in m/s^2."""
    magnetic_field_paths: tuple[str, ...] = ()
    magnetic_field_unit: str = ""
    magnetic_field_full_scale: float = FULL_SCALES["magnetic_field"]
    """Maximum absolute value of a component, in tesla."""
    time_paths: tuple[str, ...] = ()
    time_unit: str = ""
    time_interval: str = ""
    """Time between two samples of one message, such as `5 ms`, `200 Hz` or `rate Hz`."""
    select: tuple[str, ...] = ()
    """Conditions such as `T=1002` that a payload must meet."""
    required: tuple[str, ...] = ()
    """Quantities without which a sample is refused."""
    absent: str = "missing"
    """Meaning of a number that a payload leaves out: `missing`, or `zero`."""
    numeric_strings: bool = False
    """Whether `"1.5"` counts as 1.5."""
    sentinels: tuple[float, ...] = ()
    """Numbers of the payload that mean that there is no reading."""
    quaternion_tolerance: float = 0.05
    """Maximum deviation of an orientation's norm from 1."""

    @property
    def groups(self) -> tuple[str, ...]:
        """Quantities that have paths."""
        return tuple(group for group in GROUPS if getattr(self, f"{group}_paths"))

    def compile(self, *, device_time: bool = False) -> SampleReader:
        """Return the function that reads a frame. With `device_time` it reads the date as well.

        Raises:
            MappingError: The description contradicts itself, lacks something, or could mean
                two things.
        """
        make = cast("Callable[[list[Any]], Sample]", partial(tuple.__new__, Sample))
        return self._payload_mapping().compile(make, device_time=device_time, nothing="no_imu_data")

    def _payload_mapping(self) -> PayloadMapping:
        for group in self.required:
            if group not in GROUPS:
                raise MappingError(f"mapping.required takes {', '.join(GROUPS)}, not {group!r}")
        return PayloadMapping(
            (self._orientation(), *(self._vector(group) for group in VECTORS)),
            TimeMapping(self.time_paths, self.time_unit, self.time_interval),
            self.select,
            numeric_strings=self.numeric_strings,
            sentinels=self.sentinels,
            absent=self.absent,
        )

    def _orientation(self) -> Quantity:
        if not 0.0 <= self.quaternion_tolerance <= MAX_TOLERANCE:
            raise MappingError(f"mapping.quaternion_tolerance is from 0 to {MAX_TOLERANCE}")
        order = self.orientation_order
        if order not in _ORDERS:
            raise MappingError(f"mapping.orientation.order is xyzw or wxyz, not {order!r}")
        if order and not self.orientation_paths:
            raise _without_effect("orientation", "order")
        return Quantity(
            "orientation",
            self.orientation_paths,
            components=tuple("xyzw"),
            written=tuple(_ORDERS[order]),
            required="orientation" in self.required,
            finish=compile_unit_quaternion(self.quaternion_tolerance),
        )

    def _vector(self, group: str) -> Quantity:
        paths: tuple[str, ...] = getattr(self, f"{group}_paths")
        unit: str = getattr(self, f"{group}_unit")
        if unit and not paths:
            raise _without_effect(group, "unit")
        return Quantity(
            group,
            paths,
            factor=unit_factor(f"mapping.{group}.unit", unit, UNITS[group]) if paths else 1.0,
            largest=getattr(self, f"{group}_full_scale"),
            required=group in self.required,
        )


def _without_effect(group: str, what: str) -> MappingError:
    return MappingError(f"mapping.{group}.{what} has no effect: mapping.{group}.paths is empty")
