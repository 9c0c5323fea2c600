"""Covariances by REP-145: from standard deviations, and as the mark of an absent quantity."""

from collections.abc import Sequence
from typing import TypeVar

from rosbase.errors import ParameterError
from rosbase.messages import COVARIANCE_UNKNOWN, Covariance

__all__ = ["covariance_of", "measured"]

_T = TypeVar("_T")


def covariance_of(name: str, stddev: Sequence[float]) -> Covariance:
    """Return the covariance matrix with the squares of `stddev` on its diagonal.

    Args:
        name: The parameter, for messages.
        stddev: One number for all axes, or three for x, y, z; none: unknown.

    Raises:
        ParameterError: There are two numbers, or more than three, or a square is too large.
    """
    if not stddev:
        return COVARIANCE_UNKNOWN
    if len(stddev) not in (1, 3):
        raise ParameterError(f"parameter {name} takes one number or three, not {len(stddev)}")
    x, y, z = (value * value for value in (stddev if len(stddev) == 3 else [*stddev] * 3))
    if not x + y + z < float("inf"):
        raise ParameterError(f"parameter {name} is too large")
    return (x, 0.0, 0.0, 0.0, y, 0.0, 0.0, 0.0, z)


def measured(value: _T, covariance: Covariance) -> _T | None:
    """Return the value; None if its covariance begins with -1, which marks it as absent."""
    return None if covariance[0] == -1.0 else value
