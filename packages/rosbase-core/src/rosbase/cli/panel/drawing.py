"""The whole panel: a few lines of at most the width of the terminal."""

import math
from collections.abc import Sequence

from attrs import Factory, define, frozen

from rosbase.cli.panel.bars import Scale, bar
from rosbase.cli.panel.fields import Field, row, sentence
from rosbase.cli.panel.style import Style
from rosbase.imu.covariance import measured
from rosbase.messages import Imu, MagneticField, Vector3
from rosbase.utils import quat_to_rpy

__all__ = ["LEAST_HEIGHT", "LEAST_WIDTH", "Panel", "View"]

LEAST_WIDTH, LEAST_HEIGHT = 60, 10
"""Minimum size of the panel. A smaller terminal shows one line instead."""

_MOST_WIDTH = 120

_VALUE_WIDTH = 8
_COLUMN_GAP = "  "
_MICRO = 1e6


@frozen
class View:
    """Contents of a panel at one moment."""

    title: Sequence[Field]
    """Name and duration of the run."""
    counts: Sequence[Field]
    """Rate, latency, and counts of the samples; the most important ones first."""
    sample: Imu | MagneticField | None
    """Last sample."""
    note: str
    """Sentence on the state of the run."""
    colours: tuple[str, ...] = ()
    """Colours of the note."""


@define
class Panel:
    """Draws views, one after the other; scales only grow."""

    style: Style
    _accelerations: Scale = Factory(lambda: Scale(20.0))
    _rates: Scale = Factory(lambda: Scale(2.0))

    def draw(self, view: View, width: int) -> list[str]:
        """Return the lines, none of them wider than `width` characters."""
        style, width = self.style, min(width, _MOST_WIDTH)
        return [
            row(view.title, width, style),
            row(view.counts, width, style),
            *self._sample(view.sample, width),
            style.paint(sentence(view.note, width), *view.colours),
        ]

    def _sample(self, sample: Imu | MagneticField | None, width: int) -> list[str]:
        if isinstance(sample, MagneticField):
            return self._field(sample.magnetic_field, width)
        if sample is None:
            return []
        return [
            row(self._attitude(sample), width, self.style),
            *self._motion(sample, width),
        ]

    def _attitude(self, sample: Imu) -> list[Field]:
        if measured(sample.orientation, sample.orientation_covariance) is None:
            return [Field("orientation", "not measured", ("dim",))]
        degree = self.style.words("°", " deg")
        angles = quat_to_rpy(sample.orientation)
        return [
            Field(name, f"{math.degrees(angle):+7.1f}{degree}")
            for name, angle in zip(("roll", "pitch", "yaw"), angles, strict=True)
        ]

    def _motion(self, sample: Imu, width: int) -> list[str]:
        """Return a line for each axis: the acceleration to the left, the rate to the right."""
        style = self.style
        force = measured(sample.linear_acceleration, sample.linear_acceleration_covariance)
        rate = measured(sample.angular_velocity, sample.angular_velocity_covariance)
        for scale, vector in ((self._accelerations, force), (self._rates, rate)):
            if vector is not None:
                scale.include(vector.x, vector.y, vector.z)
        # An axis name in front, and a number before each bar.
        side = (width - len("x ") - len(_COLUMN_GAP)) // 2
        square = style.words("m/s²", "m/s^2")
        reach = style.words("±", "+/-")
        heads = (
            _head(("acceleration", "accel"), f"{square} {reach}{self._accelerations}", side),
            _head(("angular velocity", "gyro"), f"rad/s {reach}{self._rates}", side),
        )
        lines = [style.paint(f"  {heads[0]:{side}}{_COLUMN_GAP}{heads[1]}", "dim")]
        for axis in "xyz":
            cells = (
                self._cell(force, axis, self._accelerations, side, "cyan"),
                self._cell(rate, axis, self._rates, side, "magenta"),
            )
            lines.append(f"{axis} {_COLUMN_GAP.join(cells)}")
        return lines

    def _cell(
        self, vector: Vector3 | None, axis: str, scale: Scale, width: int, colour: str
    ) -> str:
        room = width - _VALUE_WIDTH - 1
        if vector is None:
            return self.style.paint("not measured".ljust(width), "dim")
        value: float = getattr(vector, axis)
        drawn = bar(value, scale.most, room if room % 2 else room - 1, self.style)
        return f"{_number(value)} {self.style.paint(drawn, colour)}"

    def _field(self, field: Vector3, width: int) -> list[str]:
        unit = self.style.words("µT", "uT")
        fields = [Field(axis, f"{_number(getattr(field, axis) * _MICRO)} {unit}") for axis in "xyz"]
        return [row([Field("magnetic field"), *fields], width, self.style)]


def _head(names: tuple[str, str], unit: str, width: int) -> str:
    """Return the heading of a column: with the long name, if it fits."""
    texts = [f"{name}, {unit}" for name in names]
    return next((text for text in texts if len(text) <= width), "")


def _number(value: float) -> str:
    """Return the number in eight characters."""
    text = f"{value:+{_VALUE_WIDTH}.2f}"
    return text if len(text) <= _VALUE_WIDTH else f"{value:+{_VALUE_WIDTH}.1e}"
