"""One row of a state machine's table."""

from collections.abc import Callable
from typing import Final, TypeAlias

from attrs import frozen

__all__ = ["ANY", "Action", "Guard", "Transition"]

Action: TypeAlias = Callable[[], object]
"""Called for what it does; what it returns is ignored."""

Guard: TypeAlias = Callable[[], object]
"""Called for its truth. It may be asked often, and should only look."""

ANY: Final = "*"
"""As a source: every state but the transition's target."""


@frozen
class Transition:
    """From one state to another: when, and what is done on the way.

    Raises:
        ValueError: A name is empty or stands there twice, or `ANY` where it means nothing.
    """

    source: str | tuple[str, ...]
    """The state that it leaves, or several, or `ANY`."""
    target: str
    """The state that it enters; it may be the one that it leaves."""
    when: Guard | None = None
    """Asked whether it may be taken now; without it, it always may."""
    event: str | None = None
    """The event that triggers it. Without one it is polled at every step."""
    then: Action | None = None
    """Called between leaving the source and entering the target."""
    label: str = ""
    """Why it is taken, in words, for diagrams and logs."""

    def __attrs_post_init__(self) -> None:
        """Refuses what can only be a slip."""
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
        """The source, or the sources, as a tuple in any case."""
        return (self.source,) if isinstance(self.source, str) else tuple(self.source)

    @property
    def reason(self) -> str:
        """The label; without one, the event and the guard's name in brackets, if it has one."""
        if self.label:
            return self.label
        guard = getattr(self.when, "__name__", "").lstrip("_")
        # A lambda's name is <lambda>.
        guarded = f"[{guard}]" if guard.isidentifier() else ""
        return f"{self.event or ''} {guarded}".strip()
