"""Delays before retries: longer each time, limited, and with jitter."""

from random import Random

from attrs import define, field

__all__ = ["Backoff"]


@define
class Backoff:
    """Capped exponential delays with jitter.

    The jitter takes away up to half of a delay, so that devices which were lost together
    do not come back together.
    """

    first_s: float = 0.1
    """First delay, before jitter."""
    limit_s: float = 1.0
    """Maximum delay."""
    factor: float = 2.0
    """Factor between one delay and the next."""
    rng: Random = field(factory=Random)
    """Source of the jitter."""
    _delay_s: float = field(init=False, default=0.0)

    def next_s(self) -> float:
        """Return the next delay in seconds."""
        grown = self._delay_s * self.factor if self._delay_s else self.first_s
        self._delay_s = min(grown, self.limit_s)
        return self._delay_s * (1.0 - 0.5 * self.rng.random())

    def reset(self) -> None:
        """Start again with the first delay. Call it after a proven success."""
        self._delay_s = 0.0
