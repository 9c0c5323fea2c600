"""The machine against the table, under random requests and answers."""

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle import TRANSITIONS, CallbackReturn, Machine, State, TransitionEvent
from support.strategies import answers, labels, transition_ids

PUBLIC_IDS = range(1, 8)


class MachineFollowsTheTable(RuleBasedStateMachine):
    """Whatever is asked, only edges of the table are taken, and refusals change nothing."""

    def __init__(self) -> None:
        super().__init__()
        self.machine = Machine()
        self.state = State.UNCONFIGURED
        self.primary = State.UNCONFIGURED

    def edges(self) -> list[tuple[int, str, State]]:
        return [(t.id, t.label, t.goal) for t in TRANSITIONS if t.start is self.state]

    def expect(self, event: TransitionEvent, goal: State) -> None:
        assert (event.start, event.goal) == (self.state, goal)
        if self.state.is_primary:
            self.primary = self.state
        self.state = goal

    def request(self, goals: list[State], transition_id: int, label: str) -> None:
        if goals:
            self.expect(self.machine.request(transition_id, label), goals[0])
        else:
            with pytest.raises(TransitionNotAvailableError):
                self.machine.request(transition_id, label)

    @rule(label=labels.filter(bool), ignored=transition_ids)
    def request_label(self, label: str, ignored: int) -> None:
        goals = [goal for id_, lab, goal in self.edges() if lab == label and id_ in PUBLIC_IDS]
        self.request(goals, ignored, label)

    @rule(transition_id=transition_ids)
    def request_id(self, transition_id: int) -> None:
        goals = [g for id_, _, g in self.edges() if id_ == transition_id and id_ in PUBLIC_IDS]
        self.request(goals, transition_id, "")

    @rule(choice=st.integers(0, 5))
    def request_what_is_offered(self, choice: int) -> None:
        offered = [edge for edge in self.edges() if edge[0] in PUBLIC_IDS]
        if offered:
            id_, _, goal = offered[choice % len(offered)]
            self.request([goal], id_, "")

    @rule(answer=answers)
    def finish(self, answer: CallbackReturn) -> None:
        goals = [goal for _, label, goal in self.edges() if label == answer.label]
        if goals:
            self.expect(self.machine.finish(answer), goals[0])
        else:
            with pytest.raises(TransitionNotAvailableError):
                self.machine.finish(answer)

    @precondition(lambda self: self.state in (State.UNCONFIGURED, State.INACTIVE, State.ACTIVE))
    @rule()
    def raise_error(self) -> None:
        event = self.machine.raise_error()
        assert (event.transition.id, event.transition.label) == (0, "raise_error")
        self.expect(event, State.ERRORPROCESSING)

    @precondition(lambda self: not self.state.is_primary or self.state is State.FINALIZED)
    @rule()
    def raise_error_is_refused(self) -> None:
        with pytest.raises(TransitionNotAvailableError):
            self.machine.raise_error()

    @invariant()
    def it_is_where_the_table_says(self) -> None:
        assert self.machine.state is self.state
        assert self.machine.state is not State.UNKNOWN
        assert [t.id for t in self.machine.available_transitions()] == [e[0] for e in self.edges()]
        if not self.state.is_primary:
            assert self.machine.previous_state is self.primary


TestMachineFollowsTheTable = MachineFollowsTheTable.TestCase


def test_a_label_beats_an_id() -> None:
    machine = Machine()
    assert machine.request(transition_id=1, label="shutdown").transition.id == 5


@pytest.mark.parametrize("transition_id", [0, 8, 10, 62, 255])
def test_private_and_unknown_ids_are_refused_also_while_configuring(transition_id: int) -> None:
    machine = Machine()
    machine.request(label="configure")
    with pytest.raises(TransitionNotAvailableError):
        machine.request(transition_id)
    assert machine.state is State.CONFIGURING


def test_the_refusal_names_the_request_and_the_state() -> None:
    with pytest.raises(TransitionNotAvailableError, match=r"'activate' .* unconfigured"):
        Machine().request(label="activate")
