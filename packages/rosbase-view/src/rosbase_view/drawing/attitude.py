"""A board as it is turned, seen from behind, from the right and from above."""

import math
from collections.abc import Sequence

from rosbase.utils import quat_rotate_inverse
from rosbase_view.drawing.canvas import Canvas
from rosbase_view.drawing.glyphs import Glyphs

__all__ = ["board"]

# Half the length, width and height of the board; x is ahead, y is left and z is up (REP-103).
_HALF = (1.0, 0.65, 0.12)
_AZIMUTH, _ELEVATION = math.radians(35.0), math.radians(25.0)
_CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
# Corners that differ in one coordinate share an edge.
_EDGES = [
    (a, b)
    for number, a in enumerate(_CORNERS)
    for b in _CORNERS[number + 1 :]
    if sum(p != q for p, q in zip(a, b, strict=True)) == 1
]
# On the upper side, a line from the middle ahead, with a head.
_ARROW = (((-0.4, 0.0), (0.8, 0.0)), ((0.8, 0.0), (0.5, 0.3)), ((0.8, 0.0), (0.5, -0.3)))

_Point = tuple[float, float, float]


def board(quaternion: Sequence[float], columns: int, rows: int, glyphs: Glyphs) -> list[str]:
    """Return a picture of a board with an orientation: one text for each row.

    Args:
        quaternion: Orientation of the board, as x y z w, of any length but 0.
        columns: Width in cells.
        rows: Height in cells.
        glyphs: Characters to draw with.

    Raises:
        ValueError: The quaternion is no rotation.
    """
    x, y, z, w = quaternion
    inverse = (-x, -y, -z, w)
    canvas = Canvas(columns, rows, glyphs)
    scale = min(canvas.width, canvas.height * canvas.aspect) / 2.5

    def place(point: _Point) -> tuple[float, float]:
        turned = quat_rotate_inverse(inverse, point, order="xyzw")
        right, up = _seen(turned)
        return (
            (canvas.width - 1) / 2 + right * scale,
            (canvas.height - 1) / 2 - up * scale / canvas.aspect,
        )

    for begin, end in _EDGES:
        canvas.line(place(_scaled(begin)), place(_scaled(end)))
    for (from_x, from_y), (to_x, to_y) in _ARROW:
        canvas.line(place((from_x, from_y, _HALF[2])), place((to_x, to_y, _HALF[2])))
    return canvas.text()


def _scaled(corner: tuple[int, int, int]) -> _Point:
    return corner[0] * _HALF[0], corner[1] * _HALF[1], corner[2] * _HALF[2]


def _seen(point: _Point) -> tuple[float, float]:
    """Return how far right and how far up a point of the world appears."""
    x, y, z = point
    sin_a, cos_a = math.sin(_AZIMUTH), math.cos(_AZIMUTH)
    ahead = x * cos_a + y * sin_a
    return x * sin_a - y * cos_a, ahead * math.sin(_ELEVATION) + z * math.cos(_ELEVATION)
