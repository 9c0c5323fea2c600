"""Windows of samples, as the checks of a reader get them."""

from collections.abc import Sequence

from rosbase.imu.checks.window import Window, summarise
from rosbase.imu.mapping import Sample

__all__ = ["LEVEL", "sample_of", "window_of"]

LEVEL = (0.0, 0.0, 0.0, 1.0)


def sample_of(
    acceleration: tuple[float, ...] | None = (0.0, 0.0, 9.81),
    orientation: tuple[float, ...] | None = None,
    rate: tuple[float, ...] | None = (0.0, 0.0, 0.0),
    date_ns: int | None = None,
) -> Sample:
    return Sample(orientation, rate, acceleration, None, date_ns)


def window_of(
    accelerations: Sequence[tuple[float, ...]],
    orientation: tuple[float, ...] | None = None,
    began_ns: int = 0,
    ended_ns: int = 0,
) -> Window:
    samples = [sample_of(acceleration, orientation) for acceleration in accelerations]
    return summarise(samples, began_ns, ended_ns)
