"""The kinds of entries and of notes within an entry, with the numbers that belong to each.

All times are in nanoseconds since the start of the run. `t` is the monotonic time at which the
entry began; every entry has it first.
"""

from enum import IntEnum

__all__ = [
    "HAS_PAYLOAD",
    "INTS",
    "IS_NOTE",
    "NUMBERED",
    "SECTION_OPS",
    "Kind",
    "Numbered",
    "TimerOp",
]


class Kind(IntEnum):
    """Kind of an entry, or of a note within one. The values are part of the file format."""

    # Notes: they belong to the entry that began last.
    READ_MONO = 1
    """The monotonic clock was read: value."""
    READ_DATE = 2
    """The date was read: nanoseconds since the date of the start."""
    READ_SLEPT = 3
    """`suspended_ns` was read: value."""
    FACT = 4
    """The program asked about something outside; the payload is the answer, as JSON."""
    NEW = 5
    """The program created something that has a number: class, number; the payload is its text."""
    SPOIL = 6
    """From here on the run cannot be replayed: t; the payload says why."""
    READ_LOG = 7
    """A log record was dated: nanoseconds since the date of the start.

    Not a `READ_DATE`, so that a replay at another log level reads the same for all else.
    """
    PERIOD = 8
    """Something that the program runs again and again: class, number, period in nanoseconds."""

    # Entries.
    BEGIN = 16
    """The construction of the program: t."""
    TICK = 17
    """A tick: t, number of skipped ticks, number of waiting calls."""
    TICK_END = 18
    """The end of a tick: t, number of skipped ticks, with those that this tick has made late."""
    LOOK = 19
    """The upkeep between ticks: t."""
    TIMER = 20
    """A timer was due: t, timer."""
    TIMER_OP = 21
    """Another thread operated a timer: t, timer, `TimerOp`."""
    CALL = 22
    """The first waiting call: t."""
    URGENT = 23
    """The first urgent call, during a wait: t."""
    RETURN = 24
    """A spin or a wait has ended, and its caller goes on: t, value."""
    SECTION = 25
    """A call of a transport has ended: t, transport, index in `SECTION_OPS`, whether it succeeded.

    The payload is its result or its error, as JSON. All entries since it began ran during it.
    """
    FRAME = 26
    """A transport had a frame: t, `start` of a transport, stamp.

    Each `start` has a number, as a transport has: only the transport knows whether it has any
    effect.
    """
    PUBLISH = 27
    """A thread of the user published a message: t, publisher."""
    ARRIVE = 28
    """A message came from outside: t, subscription."""
    REQUEST = 29
    """A request for a service came from outside: t, service."""
    ANSWER = 30
    """The answer to a call of a service came from outside: t, client, whether it is an answer.

    The payload begins with the number of the call among the client's calls, in 8 bytes, little
    endian. The answer follows, or the error as JSON.
    """
    CONTROL = 31
    """A request of the control socket: t, session."""
    PARAM = 32
    """A request of the middleware to set parameters: t."""
    CHANGE_STATE = 33
    """Another thread has asked for a transition: t, lifecycle node."""
    POSTED = 34
    """A thread of the user has called `call_soon`: t, thread, how often it did before."""
    LOG = 35
    """A log record from outside: t."""
    STOP = 36
    """The program was asked to stop from outside: t."""
    END = 37
    """The end of the run, after the clean-up: t."""


INTS: dict[int, int] = {
    Kind.READ_MONO: 1,
    Kind.READ_DATE: 1,
    Kind.READ_SLEPT: 1,
    Kind.FACT: 0,
    Kind.NEW: 2,
    Kind.SPOIL: 1,
    Kind.READ_LOG: 1,
    Kind.PERIOD: 3,
    Kind.BEGIN: 1,
    Kind.TICK: 3,
    Kind.TICK_END: 2,
    Kind.LOOK: 1,
    Kind.TIMER: 2,
    Kind.TIMER_OP: 3,
    Kind.CALL: 1,
    Kind.URGENT: 1,
    Kind.RETURN: 2,
    Kind.SECTION: 4,
    Kind.FRAME: 3,
    Kind.PUBLISH: 2,
    Kind.ARRIVE: 2,
    Kind.REQUEST: 2,
    Kind.ANSWER: 3,
    Kind.CONTROL: 2,
    Kind.PARAM: 1,
    Kind.CHANGE_STATE: 2,
    Kind.POSTED: 3,
    Kind.LOG: 1,
    Kind.STOP: 1,
    Kind.END: 1,
}
"""How many numbers follow each kind in a trace."""

HAS_PAYLOAD: frozenset[int] = frozenset(
    {
        Kind.FACT,
        Kind.NEW,
        Kind.SPOIL,
        Kind.SECTION,
        Kind.FRAME,
        Kind.PUBLISH,
        Kind.ARRIVE,
        Kind.REQUEST,
        Kind.ANSWER,
        Kind.CONTROL,
        Kind.PARAM,
        Kind.CHANGE_STATE,
        Kind.LOG,
    }
)
"""The kinds that have a payload."""

IS_NOTE: frozenset[int] = frozenset(
    {
        Kind.READ_MONO,
        Kind.READ_DATE,
        Kind.READ_SLEPT,
        Kind.READ_LOG,
        Kind.FACT,
        Kind.NEW,
        Kind.SPOIL,
        Kind.PERIOD,
    }
)
"""The kinds that belong to an entry; all others begin one."""

SECTION_OPS = ("create", "open", "start", "stop", "close")
"""The calls of a transport that are sections."""


class Numbered(IntEnum):
    """Classes of objects that get a number when the program creates them."""

    TIMER = 1
    PUBLISHER = 2
    SUBSCRIPTION = 3
    SERVICE = 4
    CLIENT = 5
    LIFECYCLE = 6
    TRANSPORT = 7
    THREAD = 8
    """A thread of the user that calls `call_soon`; noted at its first call."""
    LOOP = 9
    """The main loop, which has a period only; its number is 0."""


class TimerOp(IntEnum):
    """Operations on a timer by a thread other than the program's."""

    RESET = 1
    CANCEL = 2
    DESTROY = 3
    DUE = 4
    """It was due by a clock that comes from outside: its callback waits among the calls."""


NUMBERED: dict[int, Numbered] = {
    Kind.TIMER: Numbered.TIMER,
    Kind.TIMER_OP: Numbered.TIMER,
    Kind.SECTION: Numbered.TRANSPORT,
    Kind.FRAME: Numbered.TRANSPORT,
    Kind.PUBLISH: Numbered.PUBLISHER,
    Kind.ARRIVE: Numbered.SUBSCRIPTION,
    Kind.REQUEST: Numbered.SERVICE,
    Kind.ANSWER: Numbered.CLIENT,
    Kind.CHANGE_STATE: Numbered.LIFECYCLE,
}
"""Class of the object whose number follows the time, for the kinds that have one."""
