"""A board as it is turned, seen from behind, from the right and from above."""

import math
from collections.abc import Sequence
from itertools import groupby

from rosbase.utils import quat_rotate_inverse
from rosbase_view.drawing.canvas import Canvas
from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span

__all__ = ["board"]

_Point = tuple[float, float, float]

# Half the length, width and height of the board; x is ahead, y is left and z is up (REP-103).
_HALF = (1.0, 0.65, 0.12)
_AZIMUTH, _ELEVATION = math.radians(35.0), math.radians(25.0)
# From the board to the eye.
_TO_EYE = (
    -math.cos(_AZIMUTH) * math.cos(_ELEVATION),
    -math.sin(_AZIMUTH) * math.cos(_ELEVATION),
    math.sin(_ELEVATION),
)
_CORNERS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
# Corners that differ in one coordinate share an edge.
_EDGES = [
    (a, b)
    for number, a in enumerate(_CORNERS)
    for b in _CORNERS[number + 1 :]
    if sum(p != q for p, q in zip(a, b, strict=True)) == 1
]
# On the upper side, a line from the middle ahead, with a head.
_ARROW = (((-0.5, 0.0), (0.8, 0.0)), ((0.8, 0.0), (0.45, 0.3)), ((0.8, 0.0), (0.45, -0.3)))


def board(quaternion: Sequence[float], columns: int, rows: int, glyphs: Glyphs) -> list[Line]:
    """Return a picture of a board with an orientation: one line for each row.

    Only the sides that the eye can see are drawn. An arrow on the upper side points ahead.

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
    edges, arrow = (Canvas(columns, rows, glyphs) for _ in range(2))
    scale = min(edges.width, edges.height * edges.aspect) / 2.5

    def turned(point: _Point) -> _Point:
        found: _Point = quat_rotate_inverse(inverse, point, order="xyzw")
        return found

    def place(point: _Point) -> tuple[float, float]:
        right, up = _seen(turned(point))
        return (
            (edges.width - 1) / 2 + right * scale,
            (edges.height - 1) / 2 - up * scale / edges.aspect,
        )

    # How far each axis of the board points to the eye.
    facing = [_dot(turned(axis), _TO_EYE) for axis in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    for begin, end in _EDGES:
        # Two sides meet in an edge, one for each coordinate that its ends share.
        sides = [a * f for a, b, f in zip(begin, end, facing, strict=True) if a == b]
        if max(sides) > 0.0:
            edges.line(place(_scaled(begin)), place(_scaled(end)))
    if facing[2] > 0.0:
        for (from_x, from_y), (to_x, to_y) in _ARROW:
            arrow.line(place((from_x, from_y, _HALF[2])), place((to_x, to_y, _HALF[2])))
    return [_inked(*pair) for pair in zip(edges.text(), arrow.text(), strict=True)]


def _inked(edges: str, arrow: str) -> Line:
    """Return a row of both pictures; where both have dots, the arrow wins."""
    cells = [
        (e, Ink.DRAWING) if a in " \u2800" else (a, Ink.X)
        for e, a in zip(edges, arrow, strict=True)
    ]
    return tuple(
        Span("".join(text for text, _ in group), ink)
        for ink, group in groupby(cells, lambda cell: cell[1])
    )


def _scaled(corner: tuple[int, int, int]) -> _Point:
    return corner[0] * _HALF[0], corner[1] * _HALF[1], corner[2] * _HALF[2]


def _seen(point: _Point) -> tuple[float, float]:
    """Return how far right and how far up a point of the world appears."""
    x, y, z = point
    sin_a, cos_a = math.sin(_AZIMUTH), math.cos(_AZIMUTH)
    ahead = x * cos_a + y * sin_a
    return x * sin_a - y * cos_a, ahead * math.sin(_ELEVATION) + z * math.cos(_ELEVATION)


def _dot(a: _Point, b: _Point) -> float:
    return sum(p * q for p, q in zip(a, b, strict=True))
