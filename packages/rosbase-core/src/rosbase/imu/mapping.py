"""The mapping: how the payload of a device becomes a sample. Data in, a function out."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeAlias

from attrs import frozen

from rosbase.errors import MappingError
from rosbase.imu.units import UNITS, unit_factor
from rosbase.mapping.dates import TimeReader, compile_time
from rosbase.mapping.decoding import decode_payload
from rosbase.mapping.paths import MISSING, Path, parse_path, resolve
from rosbase.mapping.quantities import QuantityReader, compile_quantity, unit_quaternion
from rosbase.mapping.rejects import Reject

__all__ = ["GROUPS", "MAX_TOLERANCE", "VECTORS", "ImuMapping", "Sample", "SampleReader"]

VECTORS = tuple(UNITS)
GROUPS = ("orientation", *VECTORS)
"""The quantities that a payload may hold."""

MAX_TOLERANCE = 0.5
"""A quaternion whose norm is farther from 1 is something else, such as zero."""

_AXES = {"orientation": 4, **dict.fromkeys(VECTORS, 3)}


class Sample(NamedTuple):
    """What one payload says, in SI units; None for what it does not say."""

    orientation: tuple[float, ...] | None
    """x, y, z, w of a unit quaternion."""
    angular_velocity: tuple[float, ...] | None
    """x, y, z in rad/s."""
    linear_acceleration: tuple[float, ...] | None
    """x, y, z in m/s^2, gravity included."""
    magnetic_field: tuple[float, ...] | None
    """x, y, z in tesla."""
    device_time_ns: int | None
    """The device's date in nanoseconds since the epoch, if it was asked for and usable."""


SampleReader: TypeAlias = Callable[[bytes], Sample | Reject]
"""From a frame to a sample, or to why there is none. Never raises."""


@frozen
class ImuMapping:
    """Where the quantities are in a payload, and in which units. See `docs/mapping.md`.

    Paths are written `a.b`, `list[0].x` or `new|old`. One path for a whole quantity is a
    list of its components.
    """

    orientation_paths: tuple[str, ...] = ()
    orientation_order: str = "xyzw"
    """In which order the paths, or the list, give the quaternion: `xyzw` or `wxyz`."""
    angular_velocity_paths: tuple[str, ...] = ()
    angular_velocity_unit: str = ""
    linear_acceleration_paths: tuple[str, ...] = ()
    linear_acceleration_unit: str = ""
    magnetic_field_paths: tuple[str, ...] = ()
    magnetic_field_unit: str = ""
    time_paths: tuple[str, ...] = ()
    time_unit: str = ""
    select: tuple[str, ...] = ()
    """Conditions such as `T=1002` that a payload must meet."""
    required: tuple[str, ...] = ()
    """Quantities without which a sample is refused."""
    numeric_strings: bool = False
    """Whether `"1.5"` counts as 1.5."""
    quaternion_tolerance: float = 0.05
    """How far from 1 the norm of an orientation may be."""

    def compile(self, *, device_time: bool = False) -> SampleReader:
        """The function that reads a frame. With `device_time` it reads the date as well.

        Raises:
            MappingError: The description contradicts itself or lacks something.
        """
        if not 0.0 <= self.quaternion_tolerance <= MAX_TOLERANCE:
            raise MappingError(f"mapping.quaternion_tolerance is from 0 to {MAX_TOLERANCE}")
        readers = {group: self._quantity(group) for group in GROUPS}
        self._check_required(readers)
        return _sample_reader(
            [_condition(text) for text in self.select],
            readers,
            frozenset(self.required),
            self._time() if device_time else None,
            self.quaternion_tolerance,
        )

    def _quantity(self, group: str) -> QuantityReader | None:
        texts: tuple[str, ...] = getattr(self, f"{group}_paths")
        if not texts:
            return None
        paths = _expand(group, [parse_path(text) for text in texts])
        if group == "orientation":
            paths, factor = self._in_xyzw(paths), 1.0
        else:
            factor = unit_factor(group, getattr(self, f"{group}_unit"))
        return compile_quantity(group, paths, factor, numeric_strings=self.numeric_strings)

    def _in_xyzw(self, paths: list[Path]) -> list[Path]:
        if self.orientation_order not in ("xyzw", "wxyz"):
            raise MappingError(
                f"mapping.orientation.order is xyzw or wxyz, not {self.orientation_order!r}"
            )
        return paths if self.orientation_order == "xyzw" else [*paths[1:], paths[0]]

    def _time(self) -> TimeReader:
        if not self.time_paths:
            raise MappingError("the device's time is wanted, but mapping.time.paths is empty")
        return compile_time([parse_path(text) for text in self.time_paths], self.time_unit)

    def _check_required(self, readers: Mapping[str, QuantityReader | None]) -> None:
        for group in self.required:
            if group not in GROUPS:
                raise MappingError(f"mapping.required takes {', '.join(GROUPS)}, not {group!r}")
            if readers[group] is None:
                raise MappingError(f"{group} is required, but mapping.{group}.paths is empty")
        if not any(readers.values()):
            raise MappingError("the mapping names no quantity: set mapping.*.paths or a preset")


def _expand(group: str, paths: list[Path]) -> list[Path]:
    """One path per component; a lone path is to a list of them."""
    count = _AXES[group]
    if len(paths) == 1:
        return [tuple((*steps, index) for steps in paths[0]) for index in range(count)]
    if len(paths) != count:
        raise MappingError(f"mapping.{group}.paths takes {count} paths or one, not {len(paths)}")
    return paths


def _condition(text: str) -> tuple[Path, Any]:
    path, separator, wanted = text.partition("=")
    if not separator or not wanted.strip():
        raise MappingError(f"mapping.select takes conditions such as T=1002, not {text!r}")
    value: Any = decode_payload(f"[{wanted}]".encode())
    # What is not one value in JSON is a text without its quotes.
    is_value = isinstance(value, list) and len(value) == 1
    return parse_path(path.strip()), value[0] if is_value else wanted.strip()


def _meets(payload: object, path: Path, wanted: Any) -> bool:
    value = resolve(payload, path)
    if value is MISSING or isinstance(value, bool) is not isinstance(wanted, bool):
        return False
    return bool(value == wanted)


def _sample_reader(
    conditions: list[tuple[Path, Any]],
    readers: Mapping[str, QuantityReader | None],
    required: frozenset[str],
    read_time: TimeReader | None,
    tolerance: float,
) -> SampleReader:
    wanted = [(index, group, readers[group]) for index, group in enumerate(GROUPS)]
    steps = [(i, group, read, group in required) for i, group, read in wanted if read is not None]

    def read_sample(frame: bytes) -> Sample | Reject:
        payload = decode_payload(frame)
        if isinstance(payload, Reject):
            return payload
        for path, value in conditions:
            if not _meets(payload, path, value):
                return Reject("not_selected")
        groups: list[tuple[float, ...] | None] = [None, None, None, None]
        lacking = ""
        for index, group, read, is_required in steps:
            numbers = read(payload)
            if isinstance(numbers, Reject):
                return numbers
            if numbers is None:
                lacking = lacking or (group if is_required else "")
            elif index == 0:
                orientation = unit_quaternion(numbers, tolerance)
                if isinstance(orientation, Reject):
                    return orientation
                groups[0] = orientation
            else:
                groups[index] = numbers
        if not any(groups):
            return Reject("no_imu_data")
        if lacking:
            return Reject("missing_group", lacking)
        time_ns = read_time(payload) if read_time else None
        return Sample(groups[0], groups[1], groups[2], groups[3], time_ns)

    return read_sample
