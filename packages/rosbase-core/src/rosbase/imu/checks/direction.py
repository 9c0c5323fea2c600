"""Check that gravity points where the orientation says.

At rest this shows wrong orders, frames and signs.
"""

import math
from collections.abc import Callable, Sequence
from typing import ClassVar, TypeAlias

from rosbase.imu.checks.window import Window
from rosbase.imu.units import STANDARD_GRAVITY

__all__ = ["GravityDirection"]

_Vector: TypeAlias = tuple[float, ...]
_Pair: TypeAlias = tuple[_Vector, _Vector]
"""Orientation (x, y, z, w) and acceleration at the same moment."""

# Offsets of cheap accelerometers tilt gravity by some degrees, and filters lag behind.
_TOLERANCE = math.radians(20.0)
_AGREES = math.cos(_TOLERANCE)
# Beyond this the sensor is speeding up, braking or in a bend: a horizontal acceleration that
# tilts the force by the tolerance makes it longer by that much.
_LONGEST = 1.0 / _AGREES
_SHORTEST = 0.9
# At rest the acceleration points one way and the orientation stays; both whatever is wrong.
_SAME_FORCE = 0.1
_SAME_TURN = math.cos(math.radians(3.0) / 2.0)
# A robot brakes for a moment, and a filter settles after the start; a mistake stays.
_WINDOWS = 3
_LASTS_NS = 3_000_000_000
# Few pairs tell a direction, as they are averaged over windows.
_STRIDE = 20
# The units in which an acceleration that nobody has converted may be: m/s^2, g and mg.
_GRAVITIES = (STANDARD_GRAVITY, 1.0, 1000.0)
_MOST_HINTS = 2


class GravityDirection:
    """Turns the acceleration at rest into the world, where it must point up (+z, REP-103)."""

    reason: ClassVar[str] = "implausible_orientation"

    __slots__ = ("_began_ns", "_fits", "_hints", "_in_world", "_moving", "_windows", "finding")

    def __init__(self, order: str = "xyzw") -> None:
        """Take the order in which the mapping reads quaternions, `xyzw` or `wxyz`."""
        self.finding = ""
        """Fault of the orientation at rest, in one line; empty if there is none."""
        self._hints = _hints(order)
        self._fits = list(self._hints)
        # Windows at rest that contradict it, and windows of motion since.
        self._windows = 0
        self._moving = 0
        self._began_ns = 0
        self._in_world = (0.0, 0.0, 0.0)

    def judge(self, window: Window) -> None:
        """Compare the acceleration in a window with the orientation."""
        if not (window.is_still or self._windows):
            return
        pairs = [
            (sample.orientation, sample.linear_acceleration)
            for sample in window.samples[::_STRIDE]
            if sample.orientation is not None and sample.linear_acceleration is not None
        ]
        if len(pairs) < 2:
            return
        if not _is_at_rest(window, pairs):
            self._judge_motion(window, pairs)
        elif _share_upwards(pairs) >= _AGREES:
            self._forget()
        else:
            self._contradict(window, pairs)

    def _contradict(self, window: Window, pairs: Sequence[_Pair]) -> None:
        self._moving = 0
        if not self._windows or window.ended_ns < self._began_ns:
            self._began_ns = window.began_ns
        self._windows += 1
        # Several mistakes may explain one pose; few explain several.
        fits = [hint for hint in self._fits if self._hints[hint](pairs) >= _AGREES]
        is_settled = bool(self.finding) and fits == self._fits
        self._fits = fits
        if self._windows < _WINDOWS or window.ended_ns - self._began_ns < _LASTS_NS or is_settled:
            return
        angle = math.degrees(math.acos(max(-1.0, min(1.0, _share_upwards(pairs)))))
        asked = "; or ".join(fits[:_MOST_HINTS]) or "is the mapping of its axes right?"
        self.finding = f"at rest gravity is {angle:.0f} degrees from the orientation's up: {asked}"

    def _judge_motion(self, window: Window, pairs: Sequence[_Pair]) -> None:
        """Clear the finding if gravity is up on average: a motion ends where it began."""
        if not self._moving or window.ended_ns < self._began_ns:
            self._began_ns, self._moving, self._in_world = window.began_ns, 0, (0.0, 0.0, 0.0)
        self._moving += 1
        added = [self._in_world, *(_to_world(*pair) for pair in pairs)]
        x, y, z = (sum(axis) for axis in zip(*added, strict=True))
        self._in_world = x, y, z
        is_long = self._moving >= _WINDOWS and window.ended_ns - self._began_ns >= _LASTS_NS
        # Before there is a finding, one window is enough: braking is no rest.
        if is_long or not self.finding:
            if z >= _AGREES * math.hypot(x, y, z) > 0.0:
                self._forget()
            self._moving = 0

    def _forget(self) -> None:
        self.finding = ""
        self._fits = list(self._hints)
        self._windows = self._moving = 0


def _is_at_rest(window: Window, pairs: Sequence[_Pair]) -> bool:
    nearest = min(_GRAVITIES, key=lambda gravity: abs(math.log((window.norm or 1e-9) / gravity)))
    if not window.is_still or not _SHORTEST <= window.norm / nearest <= _LONGEST:
        return False
    (first, force), (last, _) = pairs[0], pairs[-1]
    # The cosine of half the angle between two orientations, which is the same in every
    # order, and in every pair of frames.
    if abs(sum([a * b for a, b in zip(first, last, strict=True)])) < _SAME_TURN:
        return False
    return all(math.dist(force, other) <= _SAME_FORCE * window.norm for _, other in pairs)


def _share_upwards(pairs: Sequence[_Pair]) -> float:
    """Return the cosine of the angle between the acceleration and the orientation's up."""
    upwards = length = 0.0
    for (x, y, z, w), (fx, fy, fz) in pairs:
        upwards += (
            2.0 * ((x * z - w * y) * fx + (y * z + w * x) * fy) + (1.0 - 2.0 * (x * x + y * y)) * fz
        )
        length += math.hypot(fx, fy, fz)
    return upwards / length


def _to_world(q: _Vector, f: _Vector) -> _Vector:
    (x, y, z, w), (fx, fy, fz) = q, f
    return (
        (1.0 - 2.0 * (y * y + z * z)) * fx + 2.0 * ((x * y - w * z) * fy + (x * z + w * y) * fz),
        2.0 * ((x * y + w * z) * fx + (y * z - w * x) * fz) + (1.0 - 2.0 * (x * x + z * z)) * fy,
        2.0 * ((x * z - w * y) * fx + (y * z + w * x) * fy) + (1.0 - 2.0 * (x * x + y * y)) * fz,
    )


def _hints(order: str) -> dict[str, Callable[[Sequence[_Pair]], float]]:
    """Return the usual mistakes, the likeliest first, and how well each explains the data."""
    other, turned = ("wxyz", (1, 2, 3, 0)) if order == "xyzw" else ("xyzw", (3, 0, 1, 2))

    def after(
        change: Callable[[_Vector, _Vector], _Pair], sign: float = 1.0
    ) -> Callable[[Sequence[_Pair]], float]:
        return lambda pairs: sign * _share_upwards([change(q, f) for q, f in pairs])

    return {
        f"is mapping.orientation.order {other}, not {order}?": after(
            lambda q, f: (tuple([q[index] for index in turned]), f)
        ),
        "does z point down (NED), or has the acceleration the wrong sign?": after(
            lambda q, f: (q, f), -1.0
        ),
        "is it the inverse, the world as seen from the sensor?": after(
            lambda q, f: ((-q[0], -q[1], -q[2], q[3]), f)
        ),
        "is the orientation from NED to FRD, and the acceleration not?": after(
            lambda q, f: (q, (f[0], -f[1], -f[2])), -1.0
        ),
        "is one in a frame with y left and z up (FLU), the other in y right, z down (FRD)?": after(
            lambda q, f: (q, (f[0], -f[1], -f[2]))
        ),
        "has the x axis of one the wrong sign?": after(lambda q, f: (q, (-f[0], f[1], f[2]))),
        "has the y axis of one the wrong sign?": after(lambda q, f: (q, (f[0], -f[1], f[2]))),
        "has the z axis of the acceleration the wrong sign?": after(
            lambda q, f: (q, (f[0], f[1], -f[2]))
        ),
        "are the x and y axes of one exchanged?": after(lambda q, f: (q, (f[1], f[0], f[2]))),
        "is it made of angles in degrees where radians are due?": _share_by_degrees,
    }


def _share_by_degrees(pairs: Sequence[_Pair]) -> float:
    """Return how well sines of degrees, used as radians, explain the direction of up."""
    fx, fy, fz = (sum(axis) for axis in zip(*[f for _, f in pairs], strict=True))
    roll = math.degrees(math.atan2(fy, fz))
    pitch = math.degrees(math.atan2(-fx, math.hypot(fy, fz)))
    up = (
        -math.sin(pitch),
        math.sin(roll) * math.cos(pitch),
        math.cos(roll) * math.cos(pitch),
    )
    return _share_upwards([(q, up) for q, _ in pairs])
