"""An Imu as a picture: the board as it is turned, roll, pitch and yaw, and bars for its vectors."""

import math
from collections.abc import Mapping
from typing import Any

from rosbase.utils import quat_to_rpy
from rosbase_view.drawing.attitude import board
from rosbase_view.drawing.bars import Scale, signed
from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span, line

__all__ = ["IMU", "ImuPicture"]

IMU = "sensor_msgs/msg/Imu"
_VECTORS = (
    ("linear_acceleration", "acceleration m/s²", "acceleration m/s2", 20.0),
    ("angular_velocity", "turning rad/s", "turning rad/s", 2.0),
)
_LEAST_ROWS = 4
_NUMBER_WIDTH = 9
_MOST_ROWS = 16


class ImuPicture:
    """Draws one Imu after the other; the scales of its bars only grow."""

    def __init__(self, glyphs: Glyphs) -> None:
        """Begin with the scales of a board that lies still."""
        self._glyphs = glyphs
        self._scales = {name: Scale(least) for name, _, _, least in _VECTORS}

    def draw(self, message: Mapping[str, Any], width: int, height: int) -> list[Line]:
        """Return at most `height` lines; none of an orientation that the device does not tell."""
        bars = [row for vector in _VECTORS for row in self._bars(message, *vector[:3], width)]
        head = self._angles(message)
        rows = min(_MOST_ROWS, height - len(bars) - 1)
        picture: list[Line] = []
        if head is not None and rows >= _LEAST_ROWS:
            found = board(_quaternion(message), width, rows, self._glyphs)
            picture = [line(Span(text)) for text in found]
        shown = [line(Span(head or "no orientation", Ink.PLAIN if head else Ink.DIM))]
        return [*picture, *shown, *bars][: max(0, height)]

    def _angles(self, message: Mapping[str, Any]) -> str | None:
        """Return roll, pitch and yaw; None without an orientation."""
        # A first element of -1 says that there is none.
        if message["orientation_covariance"][0] == -1.0:
            return None
        try:
            angles = quat_to_rpy(_quaternion(message), order="xyzw")
        except ValueError:
            return None
        names = ("roll", "pitch", "yaw")
        return "  ".join(
            # Without a sign for what is 0 but for rounding.
            f"{name} {round(math.degrees(angle), 1) + 0.0:6.1f}"
            for name, angle in zip(names, angles, strict=True)
        )

    def _bars(
        self, message: Mapping[str, Any], name: str, title: str, ascii_title: str, width: int
    ) -> list[Line]:
        vector, scale = message[name], self._scales[name]
        scale.include(*vector.values())
        title = title if self._glyphs.has_dots else ascii_title
        lines = [line(Span(f"{title}, {scale.most:g} at the end", Ink.DIM))]
        for axis, value in vector.items():
            bar = signed(value, scale.most, width - _NUMBER_WIDTH - 3, self._glyphs)
            lines.append(line(f"{axis} {value:{_NUMBER_WIDTH}.3f} {bar}"))
        return lines


def _quaternion(message: Mapping[str, Any]) -> tuple[float, float, float, float]:
    found = message["orientation"]
    return found["x"], found["y"], found["z"], found["w"]
