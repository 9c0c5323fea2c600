import json
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from rclpy.executors import SingleThreadedExecutor

import support.ros_walk
from rosbase.lifecycle import TRANSITIONS, CallbackReturn, State
from rosbase.roles.lifecycle_node import LifecycleNode
from support.ros import TIMEOUT_S, Client, Served, spinning
from support.waiting import wait_until


class Scripted(LifecycleNode):
    """Configures as the test says."""

    answer: Any = CallbackReturn.SUCCESS
    began: threading.Event
    may_end: threading.Event

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.began, self.may_end = threading.Event(), threading.Event()
        self.may_end.set()

    def on_configure(self, previous_state: State) -> CallbackReturn:
        self.began.set()
        assert self.may_end.wait(TIMEOUT_S)
        if isinstance(self.answer, BaseException):
            raise self.answer
        answer: CallbackReturn = self.answer
        return answer


@pytest.fixture
def served(context: Any) -> Iterator[Served]:
    served = Served(context, SingleThreadedExecutor(context=context), Scripted)
    yield served
    served.destroy()


@pytest.fixture
def running(served: Served) -> Iterator[Served]:
    """Both threads spin."""
    with (
        spinning(served.turn_executor, "executor"),
        spinning(served.turn_main_loop, "main loop"),
    ):
        yield served


@pytest.fixture
def client(context: Any, served: Served) -> Iterator[Client]:
    client = Client(context)
    yield client
    client.destroy()


@pytest.fixture
def connected(client: Client, running: Served) -> Client:
    client.connect(running)
    return client


def scripted(served: Served) -> Scripted:
    assert isinstance(served.managed, Scripted)
    return served.managed


def test_a_program_without_rosbase_walks_the_node_through_its_life(running: Served) -> None:
    script = Path(support.ros_walk.__file__)
    with subprocess.Popen(
        [sys.executable, str(script), "/served"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as walker:
        assert walker.stdout is not None
        try:
            assert walker.stdout.readline() == "ready\n"
            wait_until(lambda: running.event_readers == 1, "the walker's subscription")
            out, _ = walker.communicate("go\n", TIMEOUT_S)
        finally:
            walker.kill()
    seen = json.loads(out)
    assert seen["steps"] == [
        [True, "inactive"],
        [True, "active"],
        [True, "inactive"],
        [True, "unconfigured"],
        [True, "finalized"],
    ]
    assert seen["events"] == [
        [1, "unconfigured", "configuring"],
        [10, "configuring", "inactive"],
        [3, "inactive", "activating"],
        [30, "activating", "active"],
        [4, "active", "deactivating"],
        [40, "deactivating", "inactive"],
        [2, "inactive", "cleaningup"],
        [20, "cleaningup", "unconfigured"],
        [5, "unconfigured", "shuttingdown"],
        [50, "shuttingdown", "finalized"],
    ]


def test_all_eleven_states_are_listed_in_their_order(connected: Client) -> None:
    states = connected.call("get_available_states").available_states
    assert [(state.id, state.label) for state in states] == [
        (0, "unknown"),
        (1, "unconfigured"),
        (2, "inactive"),
        (3, "active"),
        (4, "finalized"),
        (10, "configuring"),
        (11, "cleaningup"),
        (12, "shuttingdown"),
        (13, "activating"),
        (14, "deactivating"),
        (15, "errorprocessing"),
    ]


def test_the_graph_is_the_standard_one(connected: Client) -> None:
    graph = connected.call("get_transition_graph").available_transitions
    assert [
        (t.transition.id, t.transition.label, t.start_state.id, t.goal_state.id) for t in graph
    ] == [(t.id, t.label, t.start.id, t.goal.id) for t in TRANSITIONS]
    assert len(graph) == 25


def test_the_available_transitions_are_those_of_the_present_state(connected: Client) -> None:
    def available() -> list[tuple[int, str]]:
        found = connected.call("get_available_transitions").available_transitions
        return [(t.transition.id, t.transition.label) for t in found]

    assert available() == [(1, "configure"), (5, "shutdown")]
    assert connected.change(label="configure")
    assert available() == [(2, "cleanup"), (3, "activate"), (6, "shutdown")]
    assert connected.change(label="activate")
    assert available() == [(4, "deactivate"), (7, "shutdown")]
    assert connected.change(label="shutdown")
    assert available() == []


@pytest.mark.parametrize(
    ("transition_id", "label"),
    [(0, ""), (8, ""), (10, ""), (62, ""), (255, ""), (3, ""), (1, "activate"), (1, "nonsense")],
)
def test_what_may_not_be_requested_is_refused_and_changes_nothing(
    connected: Client, transition_id: int, label: str
) -> None:
    assert not connected.change(transition_id, label)
    assert connected.state() == "unconfigured"
    # The first event is that of the next good request.
    assert connected.change(1)
    assert connected.await_events(2)[0] == (1, "configure", "unconfigured", "configuring")


def test_a_label_of_any_text_is_refused_in_one_line(
    connected: Client, caplog: pytest.LogCaptureFixture
) -> None:
    assert not connected.change(label="configure\x1b[2J\n[INFO] [boss]: all is well\u202e")
    refused = [line for line in caplog.messages if "change_state refused" in line]
    assert refused
    assert all(line.isprintable() for line in refused)


def test_a_label_beats_an_id(connected: Client) -> None:
    assert connected.change(5, "configure")
    assert connected.state() == "inactive"


@pytest.mark.parametrize(
    ("answer", "path"),
    [
        (CallbackReturn.FAILURE, [1, 11]),
        (CallbackReturn.ERROR, [1, 12, 60]),
        (ValueError("no calibration"), [1, 12, 60]),
    ],
)
def test_what_was_not_a_success_is_said_to_be_none_even_if_on_error_mended_it(
    connected: Client, running: Served, answer: Any, path: list[int]
) -> None:
    scripted(running).answer = answer
    assert not connected.change(1)
    assert connected.state() == "unconfigured"
    assert [event[0] for event in connected.await_events(len(path))] == path


def test_the_state_is_told_while_a_slow_transition_runs(connected: Client, running: Served) -> None:
    node = scripted(running)
    node.may_end.clear()
    try:
        change = connected.start_change(1)
        assert node.began.wait(TIMEOUT_S)
        assert connected.state() == "configuring"
        assert not change.done()
        assert [event[0] for event in connected.await_events(1)] == [1]
    finally:
        node.may_end.set()
    assert connected.finish(change).success
    assert connected.state() == "inactive"


def test_an_answer_wakes_the_executor(client: Client, served: Served) -> None:
    node = scripted(served)
    ending = threading.Event()
    node.may_end.clear()
    with (
        # It sleeps for longer than the client waits.
        spinning(
            lambda: served.executor.spin_once(timeout_sec=0.1 if ending.is_set() else 60.0),
            "executor",
        ),
        spinning(served.turn_main_loop, "main loop"),
    ):
        client.connect(served)
        change = client.start_change(1)
        assert node.began.wait(TIMEOUT_S)
        node.may_end.set()
        assert client.finish(change).success
        ending.set()
        served.executor.create_task(lambda: None)


def test_a_request_that_comes_during_a_transition_is_refused_at_once_as_busy(
    connected: Client, running: Served, caplog: pytest.LogCaptureFixture
) -> None:
    node = scripted(running)
    node.may_end.clear()
    first = connected.start_change(label="configure")
    assert node.began.wait(TIMEOUT_S)
    for label in ("activate", "configure", "shutdown"):
        assert not connected.finish(connected.start_change(label=label)).success
    assert connected.state() == "configuring"
    node.may_end.set()
    assert connected.finish(first).success
    assert connected.state() == "inactive"
    refusals = [
        m for m in caplog.messages if m.startswith("change_state refused: busy: configuring")
    ]
    assert len(refusals) == 3


def test_close_answers_what_a_main_loop_that_has_ended_never_begins(
    client: Client, served: Served
) -> None:
    handed_over = threading.Event()
    call_soon = served.services._call_soon

    def hand_over(call: Callable[[], object]) -> None:
        call_soon(call)
        handed_over.set()

    served.services._call_soon = hand_over
    with spinning(served.turn_executor, "executor"):
        client.connect(served)
        change = client.start_change(1)
        assert handed_over.wait(TIMEOUT_S)
        assert client.state() == "unconfigured"
        served.services.close()
        assert not client.finish(change).success
        assert not client.change(1), "a request that comes after close"
    # What was refused does not happen later either.
    while served.backend.spin_once(0):
        pass
    assert served.managed.get_state() is State.UNCONFIGURED


def test_a_main_loop_that_takes_no_calls_is_a_refusal(client: Client, served: Served) -> None:
    def refuse(call: object) -> None:
        raise RuntimeError("the main loop is gone")

    served.services._call_soon = refuse
    with spinning(served.turn_executor, "executor"):
        client.connect(served)
        assert not client.change(1)
        assert client.state() == "unconfigured"


class Broken:
    """Raises whatever it is asked."""

    def get_state(self) -> State:
        raise RuntimeError("broken")

    def get_available_transitions(self) -> Any:
        raise RuntimeError("broken")

    def describe_transition(self) -> str:
        raise RuntimeError("broken")

    def request_transition(self, transition_id: int = 0, label: str = "") -> CallbackReturn:
        raise RuntimeError("broken")

    def add_transition_listener(self, listener: object) -> None:
        pass


def test_no_exception_of_the_node_ends_the_executor(connected: Client, running: Served) -> None:
    running.services._managed = Broken()
    assert not connected.change(1)
    assert connected.state() == ""
    assert connected.call("get_available_transitions").available_transitions == []
    assert len(connected.call("get_available_states").available_states) == 11


def test_ctrl_c_in_a_callback_reaches_the_main_loop_and_the_client_has_its_answer(
    client: Client, served: Served
) -> None:
    scripted(served).answer = KeyboardInterrupt()
    with spinning(served.turn_executor, "executor"):
        client.connect(served)
        with (
            pytest.raises(KeyboardInterrupt),
            spinning(served.turn_main_loop, "main loop"),
        ):
            assert not client.change(1)
        assert client.state() == "unconfigured"


def test_an_executor_that_was_shut_down_meanwhile_does_not_trouble_the_main_loop(
    client: Client, served: Served
) -> None:
    node = scripted(served)
    node.may_end.clear()
    with spinning(served.turn_main_loop, "main loop"):
        with spinning(served.turn_executor, "executor"):
            client.connect(served)
            client.start_change(1)
            assert node.began.wait(TIMEOUT_S)
        served.executor.shutdown()
        node.may_end.set()
        wait_until(lambda: node.get_state() is State.INACTIVE, "the end of the transition")


def test_an_event_that_cannot_be_published_leaves_no_machine_half_way(
    connected: Client, running: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Unplugged:
        def publish(self, message: object) -> None:
            raise RuntimeError("no network")

    monkeypatch.setattr(running.services, "_events", Unplugged())
    assert connected.change(1)
    assert connected.state() == "inactive"


def test_an_error_that_the_node_raises_itself_is_an_event_outside_the_graph(
    connected: Client, running: Served
) -> None:
    for label in ("configure", "activate"):
        assert connected.change(label=label)
    raised = threading.Event()
    running.backend.call_soon(lambda: running.managed.raise_error(OSError("unplugged")))
    running.backend.call_soon(raised.set)
    assert raised.wait(TIMEOUT_S)
    assert connected.await_events(6)[4:] == [
        (0, "raise_error", "active", "errorprocessing"),
        (60, "transition_success", "errorprocessing", "unconfigured"),
    ]
    assert not connected.change(0, "raise_error")


def test_an_event_has_the_time_of_the_nodes_clock(connected: Client, running: Served) -> None:
    before = running.node.get_clock().now().nanoseconds
    assert connected.change(1)
    connected.await_events(2)
    after = running.node.get_clock().now().nanoseconds
    first, second = (event.timestamp for event in connected.events)
    assert before <= first <= second <= after
