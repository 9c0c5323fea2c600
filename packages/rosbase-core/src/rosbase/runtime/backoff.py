"""How long to wait before the next try: longer each time, never too long, never in step."""

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
    """The first delay, before jitter."""
    limit_s: float = 1.0
    """No delay is longer than this."""
    factor: float = 2.0
    """Each delay is this many times the one before."""
    rng: Random = field(factory=Random)
    """Where the jitter comes from."""
    _delay_s: float = field(init=False, default=0.0)

    def next_s(self) -> float:
        """The next delay in seconds."""
        grown = self._delay_s * self.factor if self._delay_s else self.first_s
        self._delay_s = min(grown, self.limit_s)
        return self._delay_s * (1.0 - 0.5 * self.rng.random())

    def reset(self) -> None:
        """Begins again with the first delay. Call it once the thing has proved to work."""
        self._delay_s = 0.0
