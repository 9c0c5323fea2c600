"""Random programs as data: what they create, and what each of their callbacks does.

`random_running` makes a manager of one. The same data makes the same program, so it can be
recorded and replayed, also by another Python: all of it can be JSON.
"""

from typing import Any

import attrs
from attrs import field, frozen
from hypothesis import strategies as st

__all__ = [
    "TICK_HZ",
    "Act",
    "Acts",
    "Outside",
    "RandomProgram",
    "Topic",
    "changed_programs",
    "from_json",
    "random_programs",
    "to_json",
]

TICK_HZ = 100

_EVERYWHERE = ("publish", "log")
"""What also a thread of its own, and a callback for frames, may do."""
_INSIDE = (
    *_EVERYWHERE,
    "read_monotonic",
    "read_date",
    "reset_timer",
    "cancel_timer",
    "set_parameter",
    "transition",
    "call",
    "call_async",
    "post",
    "look_at_latest",
    "new_timer",
    "throttle",
    "statistics",
)
_WITHOUT_WAITING = tuple(what for what in _INSIDE if what != "call")
_OUTSIDE = (*_EVERYWHERE, "transition", "post", "reset_timer", "call")


@frozen
class Act:
    """One thing that a callback does."""

    what: str
    number: int = 0
    """Which topic, timer, service or parameter; of those that there are."""
    value: int = 0


Acts = tuple[Act, ...]


def _tuple(given: Any) -> Any:
    return tuple(given)


@frozen
class Topic:
    """A topic with a publisher and a subscription."""

    depth: int
    is_latched: bool
    is_reliable: bool
    on_message: Acts = field(converter=_tuple)


@frozen
class Outside:
    """What a thread of the program's own, or of its transport, does."""

    tick: int
    """It does so once this tick has begun, or later."""
    act: Act


@frozen
class RandomProgram:
    """A manager with two nodes, one of them managed."""

    on_tick: Acts = field(converter=_tuple)
    timers: tuple[tuple[int, Acts], ...] = field(converter=_tuple)
    """Periods in milliseconds, and what they do."""
    topics: tuple[Topic, ...] = field(converter=_tuple)
    services: tuple[Acts, ...] = field(converter=_tuple)
    on_transition: Acts = field(converter=_tuple)
    on_parameter: Acts = field(converter=_tuple)
    frames: tuple[int, ...] = field(converter=_tuple)
    """Ticks after which the transport has a frame; its bytes are its number."""
    on_frame: Acts = field(converter=_tuple)
    thread: tuple[Outside, ...] = field(converter=_tuple)
    """What the thread does, in this order."""
    ticks: int = 20


def random_programs(ticks: int = 20, *, with_outside: bool = True) -> st.SearchStrategy[Any]:
    """Return programs that run for some ticks.

    Args:
        ticks: Number of ticks.
        with_outside: Whether threads take part: one of a transport, and one of the user.
    """
    inside = _some(_INSIDE, 4)
    times = st.integers(0, ticks - 5)
    outside = st.builds(Outside, times, _acts(_OUTSIDE))
    return st.builds(
        RandomProgram,
        on_tick=inside,
        timers=st.lists(st.tuples(st.integers(5, 70), inside), max_size=3),
        topics=st.lists(
            st.builds(Topic, st.integers(1, 4), st.booleans(), st.booleans(), inside),
            min_size=1,
            max_size=3,
        ),
        services=st.lists(inside, max_size=2),
        # A thread that waits in a transition of its own cannot be replayed.
        on_transition=_some(_WITHOUT_WAITING, 4),
        on_parameter=_some(_EVERYWHERE, 2),
        frames=st.lists(times, max_size=6 if with_outside else 0).map(sorted),
        on_frame=_some(_EVERYWHERE, 2),
        thread=st.lists(outside, max_size=6 if with_outside else 0).map(_by_tick),
        ticks=st.just(ticks),
    )


@st.composite
def changed_programs(draw: st.DrawFn, ticks: int = 20) -> tuple[RandomProgram, RandomProgram]:
    """Draw a program, and one that differs in what it publishes in each tick."""
    program: RandomProgram = draw(random_programs(ticks))
    value = draw(st.integers(1, 9))
    # A topic of its own, so that no other message takes its place in a queue.
    topics = (*program.topics, Topic(1000, is_latched=False, is_reliable=True, on_message=()))
    said = [Act("publish", len(program.topics), one) for one in (value, -value)]
    both = [attrs.evolve(program, topics=topics, on_tick=(*program.on_tick, act)) for act in said]
    return both[0], both[1]


def to_json(program: RandomProgram) -> dict[str, Any]:
    """Return a program as JSON has it."""
    return attrs.asdict(program)


def from_json(value: dict[str, Any]) -> RandomProgram:
    """Return the program of `to_json`."""
    acts = {name: _acts_of(value[name]) for name in _PARTS}
    topics = [
        Topic(**{**one, "on_message": _acts_of(one["on_message"])}) for one in value["topics"]
    ]
    return RandomProgram(
        **acts,
        timers=[(period, _acts_of(inner)) for period, inner in value["timers"]],
        topics=topics,
        services=[_acts_of(one) for one in value["services"]],
        frames=value["frames"],
        thread=[Outside(one["tick"], Act(**one["act"])) for one in value["thread"]],
        ticks=value["ticks"],
    )


_PARTS = ("on_tick", "on_transition", "on_parameter", "on_frame")


def _acts_of(values: list[dict[str, Any]]) -> Acts:
    return tuple(Act(**value) for value in values)


def _acts(kinds: tuple[str, ...]) -> st.SearchStrategy[Act]:
    return st.builds(Act, st.sampled_from(kinds), st.integers(0, 4), st.integers(-9, 9))


def _some(kinds: tuple[str, ...], most: int) -> st.SearchStrategy[Acts]:
    return st.lists(_acts(kinds), max_size=most).map(tuple)


def _by_tick(acts: list[Outside]) -> list[Outside]:
    return sorted(acts, key=lambda one: one.tick)
