"""Rules for restarting a child that has ended."""

from typing import Literal, TypeAlias

from attrs import field, frozen, validators

from rosbase.runtime.backoff import Backoff

__all__ = ["RestartPolicy", "RestartWhen", "Restarts"]

RestartWhen: TypeAlias = Literal["never", "on-failure", "always"]


@frozen
class RestartPolicy:
    """Whether, how soon, and how often a child is started again."""

    when: RestartWhen = field(
        default="never", validator=validators.in_(("never", "on-failure", "always"))
    )
    """Condition of a restart; `on-failure` means after a status other than 0, or a signal."""
    limit: int = field(default=5, kw_only=True, validator=validators.ge(0))
    """Maximum number of restarts in a row."""
    first_delay_s: float = field(default=0.5, kw_only=True, validator=validators.ge(0))
    """First delay in seconds; each one is twice the one before, less a random part of up to half.
    """
    longest_delay_s: float = field(default=10.0, kw_only=True, validator=validators.ge(0))
    """Maximum delay in seconds."""
    stable_s: float = field(default=10.0, kw_only=True, validator=validators.ge(0))
    """Seconds of running after which a new row of restarts begins."""


class Restarts:
    """Counts the restarts of one child."""

    def __init__(self, policy: RestartPolicy) -> None:
        self.policy = policy
        self.in_a_row = 0
        """Number of restarts since the child last ran for long enough."""
        self.has_given_up = False
        """Whether the limit prevented the last restart."""
        self._backoff = Backoff(policy.first_delay_s, policy.longest_delay_s)

    def after_end(self, *, failed: bool, ran_s: float) -> float | None:
        """Return the delay in seconds until the next start, or None for no restart."""
        if self.policy.when == "never" or (self.policy.when == "on-failure" and not failed):
            return None
        if ran_s >= self.policy.stable_s:
            self.in_a_row = 0
            self._backoff.reset()
        self.has_given_up = self.in_a_row >= self.policy.limit
        if self.has_given_up:
            return None
        self.in_a_row += 1
        return self._backoff.next_s()
