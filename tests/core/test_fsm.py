"""The task state machine: one table, one transition at a time, in one order."""

from functools import partial
from typing import Any

import attrs
import pytest
from hypothesis import given

from rosbase import BaseHandlers, BaseManager
from rosbase.fsm import ANY, Machine, Transition
from rosbase.testing import virtual_backend
from support.strategies import FsmRow, fsm_happenings, fsm_tables


@attrs.define
class Holder:
    state: str | None = None


class Traced:
    """A machine whose actions are written down."""

    def __init__(self, rows: list[Transition], holder: Holder | None = None) -> None:
        self.trace: list[str] = []
        names = {name for row in rows for name in (*row.sources, row.target)} - {ANY}
        self.machine = Machine(
            "a",
            [attrs.evolve(row, then=self.note(f"then {row.reason}".strip())) for row in rows],
            on_enter={name: self.note(f"enter {name}") for name in names},
            on_exit={name: self.note(f"exit {name}") for name in names},
            during={name: self.note(f"during {name}") for name in names},
            on_transition=lambda row: self.trace.append(f"took {row.target}"),
            holder=holder,
        )

    def note(self, words: str) -> Any:
        return lambda: self.trace.append(words)


def test_the_first_step_enters_the_initial_state() -> None:
    traced = Traced([Transition("a", "b", event="go")])
    assert (traced.machine.state, traced.machine.previous, traced.trace) == ("a", None, [])
    assert traced.machine.step() is None
    assert traced.trace == ["enter a", "during a"]


def test_actions_run_in_the_order_that_is_promised() -> None:
    traced = Traced([Transition("a", "b")])
    taken = traced.machine.step()
    assert taken is not None
    assert taken.target == "b"
    assert traced.trace == ["enter a", "exit a", "then", "enter b", "took b", "during b"]
    assert (traced.machine.state, traced.machine.previous) == ("b", "a")


def test_a_step_takes_one_transition_at_most_and_the_first_that_holds() -> None:
    machine = Machine(
        "a",
        [
            Transition("a", "c", when=lambda: False),
            Transition("a", "b", when=lambda: True),
            Transition("a", "c"),
            Transition("b", "c"),
        ],
    )
    machine.step()
    assert machine.state == "b"
    machine.step()
    assert machine.state == "c"


def test_an_event_takes_the_first_transition_of_the_state_and_runs_no_during() -> None:
    traced = Traced(
        [
            Transition("a", "c", event="go", when=lambda: False),
            Transition("a", "b", event="go"),
            Transition("b", "c"),
        ]
    )
    taken = traced.machine.send("go")
    assert taken is not None
    assert taken.target == traced.machine.state == "b"
    assert traced.trace == ["enter a", "exit a", "then go", "enter b", "took b"]


def test_an_event_that_the_present_state_does_not_know_changes_nothing() -> None:
    machine = Machine("a", [Transition("a", "b"), Transition("b", "a", event="back")])
    assert machine.send("back") is None
    assert machine.state == "a"
    with pytest.raises(ValueError, match="no transition has the event 'bakc'"):
        machine.send("bakc")


def test_a_state_may_be_left_for_itself() -> None:
    traced = Traced([Transition("a", "a", event="again")])
    traced.machine.step()
    traced.machine.send("again")
    assert traced.trace[2:] == ["exit a", "then again", "enter a", "took a"]
    assert traced.machine.previous == "a"


def test_any_is_every_state_but_the_target() -> None:
    traced = Traced([Transition("a", "b", event="go"), Transition(ANY, "stop", event="stop")])
    traced.machine.send("go")
    assert traced.machine.send("stop") is not None
    assert traced.machine.send("stop") is None
    assert traced.trace.count("enter stop") == 1


def test_steps_in_state_make_timeouts_that_are_always_the_same() -> None:
    machine: Machine = Machine(
        "a",
        [
            Transition("a", "b", when=lambda: machine.steps_in_state >= 3),
            Transition("b", "a", event="back"),
        ],
    )
    seen = []
    for _ in range(5):
        machine.step()
        seen.append((machine.state, machine.steps_in_state))
    assert seen == [("a", 0), ("a", 1), ("a", 2), ("b", 0), ("b", 1)]
    machine.send("back")
    assert machine.steps_in_state == 0
    machine.step()
    assert machine.steps_in_state == 1


def test_an_exception_on_the_way_out_leaves_the_machine_where_it_was() -> None:
    holder = Holder()
    doors = ["stuck"]
    left: list[str] = []

    def leave() -> None:
        if doors:
            raise OSError(doors.pop())
        left.append("a")

    machine = Machine("a", [Transition("a", "b")], on_exit={"a": leave}, holder=holder)
    with pytest.raises(OSError, match="stuck"):
        machine.step()
    assert (machine.state, holder.state, left) == ("a", "a", [])
    machine.step()
    assert (machine.state, holder.state, left) == ("b", "b", ["a"])


@pytest.mark.parametrize("place", ["then", "on_enter", "on_transition"])
def test_an_exception_later_leaves_it_in_the_target_and_nothing_runs_twice(place: str) -> None:
    calls: list[str] = []

    def fail(*_: object) -> None:
        calls.append(place)
        raise OSError("no")

    machine = Machine(
        "a",
        [Transition("a", "b", then=fail if place == "then" else None)],
        on_enter={"b": fail} if place == "on_enter" else {},
        on_transition=fail if place == "on_transition" else None,
    )
    with pytest.raises(OSError, match="no"):
        machine.step()
    assert (machine.state, machine.previous) == ("b", "a")
    assert machine.step() is None
    assert calls == [place]


@pytest.mark.parametrize("place", ["when", "then", "on_enter", "on_exit", "during"])
def test_an_action_cannot_drive_its_own_machine(place: str) -> None:
    def drive(here: str) -> bool:
        if here == place:
            with pytest.raises(RuntimeError, match=r"send\(\) was called from within a step"):
                machine.send("go")
            machine.step()
        return True

    machine: Machine = Machine(
        "a",
        [
            Transition("a", "b", when=lambda: drive("when"), then=lambda: drive("then")),
            Transition("b", "a", event="go"),
        ],
        on_enter={"b": lambda: drive("on_enter")},
        on_exit={"a": lambda: drive("on_exit")},
        during={"b": lambda: drive("during")},
    )
    with pytest.raises(RuntimeError, match=r"step\(\) was called from within a step"):
        machine.step()


# The state in a holder.


def test_a_holder_without_a_state_is_given_the_initial_one_at_the_first_step() -> None:
    holder = Holder()
    traced = Traced([Transition("a", "b", event="go")], holder)
    assert (traced.machine.state, holder.state) == ("a", None)
    traced.machine.step()
    assert (holder.state, traced.trace) == ("a", ["enter a", "during a"])


def test_a_machine_starts_in_the_state_that_its_holder_has() -> None:
    traced = Traced([Transition("a", "b", event="go")], Holder("b"))
    assert traced.machine.state == "b"
    traced.machine.step()
    assert traced.trace == ["enter b", "during b"]


def test_the_machine_follows_a_state_that_was_set_by_others() -> None:
    holder = Holder()
    traced = Traced([Transition("a", "b", event="go"), Transition("c", "a", event="go")], holder)
    traced.machine.step()
    traced.trace.clear()
    holder.state = "c"
    assert traced.machine.state == "a"
    assert traced.machine.step() is None
    assert traced.trace == ["exit a", "enter c", "during c"]
    assert (traced.machine.previous, traced.machine.steps_in_state) == ("a", 0)
    holder.state = "b"
    assert traced.machine.send("go") is None
    assert traced.trace[3:] == ["exit c", "enter b"]


def test_an_action_may_set_the_state_of_the_holder_and_the_next_step_follows() -> None:
    holder = Holder()
    entered: list[str] = []

    def give_up() -> None:
        entered.append("b")
        holder.state = "c"

    machine = Machine(
        "a",
        [Transition("a", "b"), Transition("c", "a", event="go")],
        on_enter={"b": give_up, "c": lambda: entered.append("c")},
        holder=holder,
    )
    machine.step()
    assert (machine.state, entered) == ("b", ["b"])
    machine.step()
    assert (machine.state, machine.previous, entered) == ("c", "b", ["b", "c"])


@pytest.mark.parametrize("state", ["bb", None])
def test_a_state_that_no_table_knows_is_named(state: str | None) -> None:
    holder = Holder()
    traced = Traced([Transition("a", "b", event="go")], holder)
    traced.machine.step()
    holder.state = state
    with pytest.raises(ValueError, match=f"set to {state!r}, which is not in the table"):
        traced.machine.step()
    holder.state = "a"
    traced.machine.step()
    assert traced.trace == ["enter a", "during a", "during a"]


def test_handlers_hold_the_state_of_the_manager() -> None:
    class Handlers(BaseHandlers):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.machine = Machine("cold", [Transition("cold", "warm")], holder=self)

    manager = BaseManager(handlers_class=Handlers, start_state="warm", backend=virtual_backend())
    assert isinstance(manager.handlers, Handlers)
    manager.handlers.machine.step()
    manager.state = "cold"
    assert manager.handlers.machine.step() is not None
    assert manager.state == "warm"
    manager.destroy_node()


# The machine against its table.


def expected_row(
    table: list[FsmRow], state: str, event: str | None, truths: list[bool]
) -> FsmRow | None:
    """The first row that is allowed, found by reading the whole table."""
    for row, truth in zip(table, truths, strict=False):
        source, target, row_event, guarded = row
        leaves = state != target if source == ANY else state in source
        if leaves and row_event == event and (truth or not guarded):
            return row
    return None


@given(fsm_tables(), fsm_happenings)
def test_the_machine_takes_the_first_allowed_row_of_its_table_and_no_other(
    table: list[FsmRow], happenings: list[tuple[tuple[str, str], list[bool]]]
) -> None:
    now: list[bool] = []
    rows = [
        Transition(
            source, target, event=event, when=partial(now.__getitem__, i) if guarded else None
        )
        for i, (source, target, event, guarded) in enumerate(table)
    ]
    holder = Holder()
    inside: list[str] = []
    entered: list[str] = []
    states = {name for row in rows for name in (*row.sources, row.target)} - {ANY}

    def enter(state: str) -> None:
        assert not inside
        inside.append(state)
        entered.append(state)

    def leave(state: str) -> None:
        assert inside == [state]
        inside.clear()

    machine = Machine(
        "a",
        rows,
        on_enter={state: partial(enter, state) for state in states},
        on_exit={state: partial(leave, state) for state in states},
        holder=holder,
    )
    events = {row[2] for row in table}
    state, changes, started = "a", ["a"], False
    for (kind, word), truths in happenings:
        now[:] = truths
        if kind == "set":
            holder.state = word if word in states else holder.state
            continue
        if kind == "send" and word not in events:
            continue
        if holder.state is not None and holder.state != state:
            state = holder.state
            changes = [*changes, state] if started else [state]
        started = True
        expected = expected_row(table, state, word or None, truths)
        taken = machine.step() if kind == "step" else machine.send(word)
        assert (taken and (taken.source, taken.target, taken.event)) == (expected and expected[:3])
        if expected is not None:
            state = expected[1]
            changes.append(state)
        assert machine.state == holder.state == state
        assert inside == [state]
        assert entered == changes
