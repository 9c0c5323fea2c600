"""Tables of the task state machine: what is refused when they are written, how they are drawn."""

from enum import Enum
from functools import partial
from typing import Any

import pytest

from rosbase import BaseHandlers
from rosbase.fsm import ANY, Machine, Transition


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"source": ""}, "a state is named by a text that is not empty, not ''"),
        ({"target": " "}, "not ' '"),
        ({"target": None}, "not None"),
        ({"source": ()}, "the transition to 'b' has no source"),
        ({"source": ("a", "")}, "not ''"),
        ({"source": ("a", "a")}, "the transition to 'b' names a source twice"),
        ({"source": ("a", ANY)}, "ANY stands alone"),
        ({"target": ANY}, "ANY cannot be the target"),
        ({"event": ""}, "has an event without a name"),
        ({"event": 3}, "has an event without a name"),
    ],
)
def test_a_row_that_can_only_be_a_slip_is_refused(arguments: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Transition(**{"source": "a", "target": "b", **arguments})


@pytest.mark.parametrize(
    ("initial", "rows", "options", "message"),
    [
        ("x", [Transition("a", "b")], {}, "the initial state 'x' is not in the table"),
        ("a", [], {}, "the initial state 'a' is not in the table"),
        (ANY, [Transition(ANY, "b")], {}, "initial state"),
        ("a", [Transition(ANY, "a")], {}, "from any state to 'a' leaves none"),
        ("a", [Transition("a", "b")], {"on_enter": {"x": print}}, "on_enter has the state 'x'"),
        ("a", [Transition("a", "b")], {"on_exit": {"x": print}}, "on_exit has the state 'x'"),
        ("a", [Transition("a", "b")], {"during": {"x": print}}, "during has the state 'x'"),
        ("b", [Transition("a", "b")], {}, "no transitions lead from 'b' to a$"),
        (
            "a",
            [Transition("a", "b"), Transition("a", "c", when=bool)],
            {},
            r"from 'a' to 'c' \(polled\) can never be taken",
        ),
        (
            "a",
            [Transition("a", "b", event="go"), Transition(("b", "a"), "a", event="go")],
            {},
            r"from 'a' to 'a' \(on 'go'\) can never be taken",
        ),
        (
            "a",
            [Transition(ANY, "b"), Transition("b", "a"), Transition(ANY, "a", when=bool)],
            {},
            r"from 'b' to 'a' \(polled\) can never be taken",
        ),
    ],
)
def test_a_table_that_can_only_be_a_slip_is_refused_in_one_line(
    initial: str, rows: list[Transition], options: Any, message: str
) -> None:
    with pytest.raises(ValueError, match=message) as refusal:
        Machine(initial, rows, **options)
    assert "\n" not in str(refusal.value)


def test_a_state_that_only_others_set_needs_a_holder() -> None:
    rows = [Transition("a", "b"), Transition("c", "a")]
    with pytest.raises(ValueError, match="no transitions lead from 'a' to c"):
        Machine("a", rows)
    assert Machine("a", rows, holder=BaseHandlers()).states == ("a", "b", "c")


def test_a_row_for_any_state_may_come_after_one_that_always_holds() -> None:
    machine = Machine("a", [Transition("a", "b"), Transition(ANY, "c")])
    assert [machine.step() and machine.state for _ in range(3)] == ["b", "c", None]


def test_the_diagram_shows_every_transition_and_where_it_ends() -> None:
    def has_target() -> bool:
        return True

    machine = Machine(
        "a",
        [
            Transition("a", "b", when=has_target),
            Transition("b", "a", event="lost", when=has_target),
            Transition("b", "c", when=lambda: True, label="close enough"),
            Transition("c", "d"),
            Transition(ANY, "stop", event="stop"),
        ],
    )
    assert machine.to_mermaid() == (
        "stateDiagram-v2\n"
        "    [*] --> a\n"
        "    a --> b : [has_target]\n"
        "    b --> a : lost [has_target]\n"
        "    b --> c : close enough\n"
        "    c --> d\n"
        "    a --> stop : stop\n"
        "    b --> stop : stop\n"
        "    c --> stop : stop\n"
        "    d --> stop : stop\n"
        "    stop --> [*]\n"
    )


def test_a_transition_gives_its_reason_in_words_if_there_are_any() -> None:
    def _is_near() -> bool:
        return True

    assert Transition("a", "b", when=_is_near).reason == "[is_near]"
    assert Transition("a", "b", when=lambda: True).reason == ""
    assert Transition("a", "b", when=partial(bool, 1), event="go").reason == "go"
    assert Transition("a", "b", when=_is_near, event="go", label="near").reason == "near"


def test_names_that_a_diagram_cannot_take_get_an_alias() -> None:
    machine = Machine(
        "wait: cup",
        [
            Transition("wait: cup", "End", label='a --> "b"; 50%'),
            Transition("End", "s1", label="two\nlines"),
            Transition("s1", "größe"),
        ],
    )
    assert machine.to_mermaid() == (
        "stateDiagram-v2\n"
        '    state "wait#58; cup" as s2\n'
        '    state "End" as s3\n'
        '    state "größe" as s4\n'
        "    [*] --> s2\n"
        "    s2 --> s3 : a --#gt; #quot;b#quot;#59; 50#37;\n"
        "    s3 --> s1 : two lines\n"
        "    s1 --> s4\n"
        "    s4 --> [*]\n"
    )


def test_a_diagram_calls_members_of_a_string_enumeration_by_their_value() -> None:
    class Task(str, Enum):
        SEARCH = "search"
        GRASP = "grasp it"

    drawn = Machine(Task.SEARCH, [Transition(Task.SEARCH, Task.GRASP)]).to_mermaid()
    assert "Task" not in drawn
    assert "    search --> s1\n" in drawn
    assert 'state "grasp it" as s1' in drawn
