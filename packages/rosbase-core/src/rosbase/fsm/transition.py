"""One row of a state machine's table."""

from collections.abc import Callable
from typing import Final, TypeAlias

from attrs import frozen

__all__ = ["ANY", "Action", "Guard", "Transition"]

Action: TypeAlias = Callable[[], object]
"""Function called for its effect; its return value is ignored."""

Guard: TypeAlias = Callable[[], object]
"""Function called for its truth value. It may be called often, and should change nothing."""

ANY: Final = "*"
"""Source that stands for every state except the transition's target."""


@frozen
class Transition:
    """A transition between states: its condition and its action.

    Raises:
        ValueError: A name is empty or repeated, or `ANY` is used where it means nothing.
    """

    source: str | tuple[str, ...]
    """State that it leaves, or several, or `ANY`."""
    target: str
    """State that it enters; may be the one that it leaves."""
    when: Guard | None = None
    """Guard: returns whether it may be taken now. Without one, it always may."""
    event: str | None = None
    """Event that triggers it. Without one it is polled at every step."""
    then: Action | None = None
    """Called between leaving the source and entering the target."""
    label: str = ""
    """Reason for the transition, for diagrams and logs."""

    def __attrs_post_init__(self) -> None:
        """Refuse rows that can only be a mistake."""
        if not self.sources:
            raise ValueError(f"the transition to {self.target!r} has no source")
        for name in (*self.sources, self.target):
            if not isinstance(name, str) or not name.strip():
                raise ValueError(f"a state is named by a text that is not empty, not {name!r}")
        if len(set(self.sources)) < len(self.sources):
            raise ValueError(f"the transition to {self.target!r} names a source twice")
        if self.target == ANY:
            raise ValueError("ANY cannot be the target of a transition")
        if ANY in self.sources and len(self.sources) > 1:
            raise ValueError(f"ANY stands alone as the source of the transition to {self.target!r}")
        if self.event is not None and not (isinstance(self.event, str) and self.event.strip()):
            raise ValueError(f"the transition to {self.target!r} has an event without a name")

    @property
    def sources(self) -> tuple[str, ...]:
        """Source or sources, always as a tuple."""
        return (self.source,) if isinstance(self.source, str) else tuple(self.source)

    @property
    def reason(self) -> str:
        """Label; without one, the event and the guard's name in brackets, if it has one."""
        if self.label:
            return self.label
        guard = getattr(self.when, "__name__", "").lstrip("_")
        # A lambda's name is <lambda>.
        guarded = f"[{guard}]" if guard.isidentifier() else ""
        return f"{self.event or ''} {guarded}".strip()
