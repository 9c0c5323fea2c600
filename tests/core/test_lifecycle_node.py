import threading
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.contracts.backend import BackendOptions
from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle import CALLBACKS, TRANSITIONS, CallbackReturn, State, TransitionEvent
from rosbase.local import Bus, LocalBackend
from rosbase.messages import Header
from rosbase.roles.lifecycle_node import LifecycleNode
from support.strategies import answers

ANSWERABLE = st.one_of(answers, st.sampled_from([None, True, 97, "SUCCESS", ValueError("no")]))


class Scripted(LifecycleNode):
    """Answers what the test says, and notes what it was asked."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.answers: dict[str, Any] = {}
        self.asked: list[tuple[str, State]] = []
        self.events: list[TransitionEvent] = []
        self.add_transition_listener(self.events.append)

    def _answer(self, name: str, previous: State) -> Any:
        self.asked.append((name, previous))
        answer = self.answers.get(name, CallbackReturn.SUCCESS)
        if isinstance(answer, BaseException):
            raise answer
        return answer


def _callback(name: str) -> Any:
    return lambda self, previous: self._answer(name, previous)


for _name in CALLBACKS.values():
    setattr(Scripted, _name, _callback(_name))


def make() -> Scripted:
    return Scripted(backend=LocalBackend(BackendOptions("scripted"), Bus()))


@pytest.fixture
def node() -> Iterator[Scripted]:
    node = make()
    yield node
    node.destroy_node()


def test_the_whole_life_goes_round(node: Scripted) -> None:
    for trigger, state in [
        (node.trigger_configure, State.INACTIVE),
        (node.trigger_activate, State.ACTIVE),
        (node.trigger_deactivate, State.INACTIVE),
        (node.trigger_cleanup, State.UNCONFIGURED),
        (node.trigger_shutdown, State.FINALIZED),
    ]:
        assert trigger() is CallbackReturn.SUCCESS
        assert node.get_state() is state
    assert [name for name, _ in node.asked] == [
        "on_configure",
        "on_activate",
        "on_deactivate",
        "on_cleanup",
        "on_shutdown",
    ]


@given(st.lists(st.tuples(st.sampled_from(TRANSITIONS), ANSWERABLE, ANSWERABLE), max_size=15))
def test_every_request_and_answer_ends_where_the_table_says(script: list[Any]) -> None:
    node = make()
    for request, answer, error_answer in script:
        before = node.get_state()
        node.answers = dict.fromkeys(CALLBACKS.values(), answer) | {"on_error": error_answer}
        node.events.clear()
        if request.id >= 10 or request.start is not before:
            with pytest.raises(TransitionNotAvailableError):
                node.request_transition(request.id)
            assert node.get_state() is before
            assert node.events == []
            continue
        effective = answer if isinstance(answer, CallbackReturn) else CallbackReturn.ERROR
        assert node.request_transition(request.id) is effective
        steps = [event.transition for event in node.events]
        assert all(step in TRANSITIONS for step in steps)
        assert all(a.goal is b.start for a, b in pairwise(steps))
        assert (steps[0], steps[-1].goal) == (request, node.get_state())
        assert node.get_state().is_primary
        # One event per edge: two, or three with error processing.
        assert len(steps) == (3 if effective is CallbackReturn.ERROR else 2)
        assert all(previous is before for _, previous in node.asked[-(len(steps) - 1) :])
    node.destroy_node()


def test_raising_is_error_kept_with_its_traceback(
    node: Scripted, caplog: pytest.LogCaptureFixture
) -> None:
    error = ValueError("no calibration")
    node.answers["on_configure"] = error
    assert node.trigger_configure() is CallbackReturn.ERROR
    assert node.last_error is error
    assert node.get_state() is State.UNCONFIGURED
    (record,) = caplog.records
    assert record.message == "on_configure raised ValueError: no calibration"
    assert record.exc_info is not None
    assert record.exc_info[1] is error


def test_a_wrong_return_type_is_an_error_that_says_so(node: Scripted) -> None:
    node.answers["on_configure"] = None
    assert node.trigger_configure() is CallbackReturn.ERROR
    assert str(node.last_error) == "on_configure must return a CallbackReturn, not None"


def test_an_error_in_on_error_ends_finalized(node: Scripted) -> None:
    node.answers = {"on_configure": CallbackReturn.ERROR, "on_error": RuntimeError("worse")}
    node.trigger_configure()
    assert node.get_state() is State.FINALIZED


def test_ctrl_c_in_a_callback_brings_the_machine_to_rest_and_goes_on(node: Scripted) -> None:
    node.answers["on_configure"] = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        node.trigger_configure()
    assert node.get_state() is State.UNCONFIGURED
    node.answers.clear()
    assert node.trigger_configure() is CallbackReturn.SUCCESS


def test_a_raised_error_goes_through_on_error_with_the_state_before(node: Scripted) -> None:
    node.trigger_configure()
    node.trigger_activate()
    error = OSError("lost")
    assert node.raise_error(error) is CallbackReturn.SUCCESS
    assert node.asked[-1] == ("on_error", State.ACTIVE)
    assert node.last_error is error
    assert node.get_state() is State.UNCONFIGURED
    assert [e.transition.label for e in node.events[-2:]] == ["raise_error", "transition_success"]


def test_one_transition_at_a_time_and_get_state_answers_meanwhile(node: Scripted) -> None:
    entered, leave = threading.Event(), threading.Event()

    class Slow(Scripted):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            entered.set()
            assert leave.wait(10)
            return CallbackReturn.SUCCESS

    slow = Slow(backend=LocalBackend(BackendOptions("slow"), Bus()))
    thread = threading.Thread(target=slow.trigger_configure)
    thread.start()
    assert entered.wait(10)
    assert slow.get_state() is State.CONFIGURING
    with pytest.raises(TransitionNotAvailableError, match="busy: configuring since 0 s"):
        slow.trigger_shutdown()
    with pytest.raises(TransitionNotAvailableError, match="busy: configuring since 0 s"):
        slow.raise_error(OSError())
    leave.set()
    thread.join()
    assert slow.get_state() is State.INACTIVE
    slow.destroy_node()


def test_nothing_is_published_while_not_active(node: Scripted) -> None:
    got: list[Header] = []
    node.create_subscription(Header, "scan", got.append, 100)
    publisher = node.create_publisher(Header, "scan", 100)
    sent = []
    for trigger in (
        node.trigger_configure,
        node.trigger_activate,
        node.trigger_deactivate,
        node.trigger_cleanup,
        node.trigger_shutdown,
    ):
        sent.append(publisher.publish(Header()))
        trigger()
    sent.append(publisher.publish(Header()))
    while node._backend.spin_once(0.0):
        pass
    assert sent == [False, False, True, False, False, False]
    assert len(got) == 1


def test_a_listener_that_raises_never_leaves_the_machine_half_way(node: Scripted) -> None:
    node.add_transition_listener(lambda event: 1 / 0)
    assert node.trigger_configure() is CallbackReturn.SUCCESS
    assert node.get_state() is State.INACTIVE


def test_a_listener_that_exits_is_heard_once_the_machine_is_at_rest(node: Scripted) -> None:
    def leave(event: TransitionEvent) -> None:
        raise SystemExit(3)

    node.add_transition_listener(leave)
    with pytest.raises(SystemExit):
        node.trigger_configure()
    assert node.get_state() is State.INACTIVE


def test_a_second_ctrl_c_in_on_error_brings_the_machine_to_rest_too(node: Scripted) -> None:
    node.answers = {"on_configure": CallbackReturn.ERROR, "on_error": KeyboardInterrupt()}
    with pytest.raises(KeyboardInterrupt):
        node.trigger_configure()
    assert node.get_state() is State.FINALIZED


class PlainLogger:
    """What programs give: the five levels, and nothing else."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.said: list[str] = []

    def info(self, message: str, once: bool = False) -> None:
        self.said.append(message)

    error = warning = debug = critical = info


class BrokenLogger(PlainLogger):
    def error(self, message: str, once: bool = False) -> None:
        raise OSError("disk full")


@pytest.mark.parametrize("kind", [PlainLogger, BrokenLogger])
def test_a_logger_of_the_programs_own_never_leaves_the_machine_half_way(
    kind: type[PlainLogger],
) -> None:
    node = Scripted(
        backend=LocalBackend(BackendOptions("scripted"), Bus()), custom_logger=kind, node_name="own"
    )
    node.answers["on_configure"] = ValueError("no calibration")
    assert node.trigger_configure() is CallbackReturn.ERROR
    assert node.get_state() is State.UNCONFIGURED
    said: Any = node.logger
    said.log_throttle("again", 1.0)
    assert said.said[-1] == "again"
    if kind is PlainLogger:
        assert "on_configure raised ValueError: no calibration\n  Traceback" in said.said[0]
    node.destroy_node()


def test_a_lone_lifecycle_node_comes_up_and_goes_down_by_itself() -> None:
    node = make()
    node.autostart = "activate"
    node.add_transition_listener(
        lambda event: node._request_stop() if event.goal is State.ACTIVE else None
    )
    node.start_spin_standalone()
    assert [name for name, _ in node.asked] == [
        "on_configure",
        "on_activate",
        "on_deactivate",
        "on_cleanup",
        "on_shutdown",
    ]
    assert node.get_state() is State.FINALIZED
