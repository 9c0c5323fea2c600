"""The conductor: what all seams of rosbase know of a recording or a replay.

A clock that is recorded or replayed has a `conductor`, which is how it reaches every seam. Any
other program has none, and runs the classes that know nothing of it.

Inside is the thread that holds the turn. All others are outside: readers of transports, links to
children, the control socket, threads of the user. What they hand over comes in when the turn is
free, and no thread waits for that.
"""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol, TypeAlias, TypeVar

# Every program imports this module, and most are neither recorded nor replayed.
if TYPE_CHECKING:
    from rosbase.clock import Clock
    from rosbase.entries.kinds import Kind, Numbered
    from rosbase.entries.payloads import Json, Payload
    from rosbase.entries.script import Entry
    from rosbase.entries.turn import Turn
    from rosbase.runtime.executor import Executor

__all__ = ["Conductor", "Play", "conductor_of"]

T = TypeVar("T")
Play: TypeAlias = Callable[["Entry"], object]
"""Function that replays an entry that came from outside."""


class Conductor(Protocol):
    """Records the entries of a program, or replays them."""

    @property
    def is_replay(self) -> bool:
        """Whether entries come from a recording."""
        ...

    @property
    def is_of_middleware(self) -> bool:
        """Whether this is a replay of a program whose messages left its process."""
        ...

    @property
    def clock(self) -> "Clock":
        """The clock of the program, whose `conductor` is this."""
        ...

    @property
    def turn(self) -> "Turn":
        """The turn: whoever holds it is inside. For seams that ask with each message."""
        ...

    @property
    def is_inside(self) -> bool:
        """Whether the calling thread runs the program now."""
        ...

    def make_executor(self) -> "Executor":
        """Return the executor of the program; called once."""
        ...

    def begin(self, backend: Any) -> None:
        """Note that the backend of the program is open, before the first component is built."""
        ...

    def end(self, error: BaseException | None) -> None:
        """Note that the program has ended, after its clean-up.

        Args:
            error: What has ended it; None for a stop.
        """
        ...

    def number(self, what: "Numbered", text: str, play: Play) -> int:
        """Return the number of something that the program creates, counted for each kind.

        A thread outside gets -1, and what it creates is not replayed: that spoils the recording.

        Args:
            what: What it is.
            text: Its topic, service, callback or plugin, by which changed code is matched.
            play: What a replay does with an entry that has this number.
        """
        ...

    def register(self, kind: "Kind", play: Play) -> None:
        """Say what a replay does with entries of a kind whose objects have no number."""
        ...

    def come_in(
        self, kind: "Kind", numbers: tuple[int, ...], payload: "Payload", run: Callable[[], object]
    ) -> None:
        """Let something from outside come into the program, as an entry. Never waits.

        Inside, it runs at once, and belongs to the entry that runs. Outside, it is queued, and runs
        as soon as the turn is free, on this thread or another. A replay ignores it outside: all
        that came from outside is in the recording.

        Args:
            kind: What it is.
            numbers: Its numbers after the time, as in `kinds`.
            payload: Its content; empty bytes for a kind that has none.
            run: Takes it into the program, on the thread that holds the turn.
        """
        ...

    def enter(
        self, kind: "Kind", numbers: tuple[int, ...], payload: "Payload", run: Callable[[], T]
    ) -> T:
        """Run something from outside as an entry, and return its result.

        It waits a second for the turn; then it runs anyway, which spoils the recording.
        """
        ...

    def fact(self, read: "Callable[[], Json]") -> "Json":
        """Return what the program asks about something outside; outside, only read it.

        Args:
            read: Returns the answer. A replay calls it only if the recording has no answer, as in
                a program that has changed; it then returns what is known without the outside.
        """
        ...

    def section(self, transport: int, op: str, call: "Callable[[], Json]") -> "Json":
        """Call a transport with the turn free, so that its threads can end, and note the result.

        Args:
            transport: Its number.
            op: One of `SECTION_OPS`.
            call: The call. In a replay, it is not called: the recorded result is returned, or the
                recorded error raised.
        """
        ...

    def aside(self, call: Callable[[], object]) -> None:
        """Run upkeep of a backend with the turn free. It is no entry, and not replayed."""
        ...

    def spoil(self, reason: str) -> None:
        """Note that the run cannot be replayed from here on. Call it from any thread."""
        ...


def conductor_of(clock: object) -> Conductor | None:
    """Return the conductor of a clock; None if nobody records or replays the program."""
    return getattr(clock, "conductor", None)
