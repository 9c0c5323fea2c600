"""What follows from the end of a child, decided without a clock and without processes."""

from types import SimpleNamespace
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rosbase import RestartPolicy
from rosbase.logger import RosbaseLogger
from rosbase.processes.child import ChildProcess
from rosbase.processes.journal import Journal
from rosbase.processes.judge import Judge
from rosbase.processes.launch import CommandLaunch

SECOND_NS = 1_000_000_000
POLICIES = [
    RestartPolicy(),
    RestartPolicy("always", first_delay_s=0.0),
    RestartPolicy("on-failure", first_delay_s=0.1, limit=1),
]
codes = st.sampled_from([0, 1, 3, -2, -9, -11, -15, 130, 143])


def child_of(policy: RestartPolicy, *, is_required: bool = False) -> ChildProcess:
    return ChildProcess("x", CommandLaunch("true"), policy, is_required=is_required)


def life_of(child: ChildProcess, code: int) -> Any:
    """What the judge asks of a life that has ended with that code."""
    child.exit_code = code
    may_be_a_stop = code in {0, -1, -2, -15, 129, 130, 143}
    return SimpleNamespace(
        child=child,
        started_ns=0,
        has_failed=code != 0,
        may_be_a_stop=may_be_a_stop,
        is_reported=True,
        is_settled=True,
    )


@given(st.sampled_from(POLICIES), st.booleans(), codes, st.integers(0, 3 * SECOND_NS))
def test_once_a_stop_is_asked_for_nothing_follows(
    policy: RestartPolicy, is_required: bool, code: int, stop_ns: int
) -> None:
    journal = Journal(RosbaseLogger("test"))
    judge = Judge(journal)
    called: list[int] = []
    judge.have_called(lambda: called.append(judge.status))
    judge.ended(life_of(child_of(policy, is_required=is_required), code), 0)
    before = (list(judge.to_start(stop_ns)), judge.status, list(called))
    journal.is_ending = True
    assert list(judge.to_start(10 * SECOND_NS)) == []
    assert (judge.status, called) == before[1:]
    assert judge.due_ns is None
    judge.ended(life_of(child_of(policy, is_required=True), code), 10 * SECOND_NS)
    assert (list(judge.to_start(20 * SECOND_NS)), judge.status) == ([], before[1])


@given(codes, st.integers(0, SECOND_NS))
def test_what_may_be_a_stop_is_judged_half_a_second_later_and_the_rest_at_once(
    code: int, now_ns: int
) -> None:
    judge = Judge(Journal(RosbaseLogger("test")))
    child = child_of(POLICIES[1])
    life = life_of(child, code)
    judge.ended(life, 0)
    assert judge.due_ns == (SECOND_NS // 2 if life.may_be_a_stop else 0)
    is_due = not life.may_be_a_stop or now_ns >= SECOND_NS // 2
    assert list(judge.to_start(now_ns)) == ([child] if is_due else [])


@given(codes)
def test_a_required_child_gives_the_program_the_status_that_a_shell_would_give(code: int) -> None:
    judge = Judge(Journal(RosbaseLogger("test")))
    called: list[int] = []
    judge.ended(life_of(child_of(POLICIES[0], is_required=True), code), 0)
    assert list(judge.to_start(SECOND_NS // 2 - 1)) == []
    assert judge.status == 0
    assert list(judge.to_start(SECOND_NS // 2)) == []
    judge.have_called(lambda: called.append(judge.status))
    assert called == [code if code >= 0 else 128 - code]


def test_a_required_child_that_cannot_be_started_again_ends_the_program() -> None:
    judge = Judge(Journal(RosbaseLogger("test")))
    child = child_of(RestartPolicy("always", limit=0), is_required=True)
    judge.could_not_start(child, 0)
    assert judge.status == 1
