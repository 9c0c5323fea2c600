"""An Imu as a picture: the board as it is turned, roll, pitch and yaw, and bars for its vectors."""

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from rosbase.utils import quat_to_rpy
from rosbase_view.drawing.attitude import board
from rosbase_view.drawing.bars import Scale, signed
from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span, fitted, joined, line

__all__ = ["IMU", "ImuPicture"]

IMU = "sensor_msgs/msg/Imu"


class _Vector(NamedTuple):
    title: str
    unit: str
    ascii_unit: str
    least: float
    """End of its bars, as long as no component is longer."""


_VECTORS = {
    "linear_acceleration": _Vector("acceleration", "m/s²", "m/s2", 20.0),
    "angular_velocity": _Vector("angular velocity", "rad/s", "rad/s", 2.0),
}
_INKS = {"x": Ink.X, "y": Ink.Y, "z": Ink.Z}
_NUMBER_WIDTH = 8
_LEAST_ROWS, _MOST_ROWS = 4, 16
# From this width on, the board is beside the numbers if there is no room above them.
_BESIDE, _GAP = 64, 3


class ImuPicture:
    """Draws one Imu after the other; the scales of its bars only grow."""

    def __init__(self, glyphs: Glyphs) -> None:
        """Begin with the scales of a board that lies still."""
        self._glyphs = glyphs
        self._scales = {name: Scale(vector.least) for name, vector in _VECTORS.items()}

    def draw(self, message: Mapping[str, Any], width: int, height: int) -> list[Line]:
        """Return at most `height` lines; no board without an orientation."""
        angles = _angles(message)
        if angles is None:
            head = line(Span("no orientation", Ink.DIM))
            return [head, *self._vectors(message, width)][: max(0, height)]
        numbers = 1 + len(_VECTORS) * 4
        rows = min(_MOST_ROWS, height - numbers)
        if rows < _MOST_ROWS // 2 and width >= _BESIDE:
            return self._beside(message, angles, width, min(height, numbers))
        picture = [] if rows < _LEAST_ROWS else self._board(message, width, rows)
        return [*picture, _angles_line(angles), *self._vectors(message, width)][: max(0, height)]

    def _beside(
        self, message: Mapping[str, Any], angles: list[float], width: int, height: int
    ) -> list[Line]:
        """Return the board at the left, and the numbers at the right."""
        left = min(width // 2, 4 * height)
        picture = self._board(message, left, height)
        # Without names, there is room for all three.
        right = [_angles_line(angles), *self._vectors(message, width - left - _GAP)]
        return [
            joined((fitted(one, left), line(" " * _GAP), other))
            for one, other in zip(picture, right, strict=False)
        ]

    def _board(self, message: Mapping[str, Any], width: int, height: int) -> list[Line]:
        return board(_quaternion(message), width, height, self._glyphs)

    def _vectors(self, message: Mapping[str, Any], width: int) -> list[Line]:
        return [row for name in _VECTORS for row in self._bars(message[name], name, width)]

    def _bars(self, value: Mapping[str, float], name: str, width: int) -> list[Line]:
        vector, scale = _VECTORS[name], self._scales[name]
        scale.include(*value.values())
        unit, sign = (vector.unit, "±") if self._glyphs.has_dots else (vector.ascii_unit, "+-")
        lines = [line(Span(f"{vector.title}, {unit}, {sign}{scale.most:g}", Ink.DIM))]
        bar_width = width - _NUMBER_WIDTH - 3
        for axis, component in value.items():
            bar = signed(component, scale.most, bar_width, self._glyphs)
            lines.append(line(f"{axis} {component:{_NUMBER_WIDTH}.3f} ", Span(bar, _INKS[axis])))
        return lines


def _angles(message: Mapping[str, Any]) -> list[float] | None:
    """Return roll, pitch and yaw in degrees; None without an orientation."""
    # A first element of -1 says that there is none.
    if message["orientation_covariance"][0] == -1.0:
        return None
    try:
        angles = quat_to_rpy(_quaternion(message), order="xyzw")
    except ValueError:
        return None
    # Without a sign for what is 0 but for rounding.
    return [round(math.degrees(angle), 1) + 0.0 for angle in angles]


def _angles_line(angles: list[float]) -> Line:
    parts: list[Span | str] = []
    for name, angle, ink in zip(("roll", "pitch", "yaw"), angles, _INKS.values(), strict=True):
        parts += [Span(f"{name} ", ink), f"{angle:6.1f}  "]
    return line(*parts)


def _quaternion(message: Mapping[str, Any]) -> tuple[float, float, float, float]:
    found = message["orientation"]
    return found["x"], found["y"], found["z"], found["w"]
