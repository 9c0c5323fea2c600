"""Code of rclpy on the backend's node, beside rosbase: what serves it, and what it may stop."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter as RosParameter
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String as RosString
from test_msgs.action import Fibonacci
from type_description_interfaces.srv import GetTypeDescription

from rosbase.contracts.backend import BackendOptions
from rosbase.messages import String
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult
from rosbase_ros2.backend import Ros2Backend
from support.program import running
from support.ros import TIMEOUT_S, Open, ParameterTool, spin_until
from support.waiting import wait_until

Service = GetTypeDescription


class Native:
    """A service of the program on a backend's node, and a client of it on the same node."""

    def __init__(self, backend: Ros2Backend, group: Any = None) -> None:
        self.node = backend.node
        self.threads: list[threading.Thread] = []
        self.began, self.may_end = threading.Event(), threading.Event()
        self.may_end.set()
        self.node.create_service(Service, "native", self._answer, callback_group=group)
        self.client = self.node.create_client(Service, "native", callback_group=group)
        assert self.client.wait_for_service(TIMEOUT_S)

    def _answer(self, request: Any, response: Any) -> Any:
        self.threads.append(threading.current_thread())
        self.began.set()
        assert self.may_end.wait(TIMEOUT_S)
        response.successful = True
        return response

    def ask(self) -> Any:
        """Sends a request; gives the future of the response."""
        return self.client.call_async(Service.Request())


@contextmanager
def blocked(native: Native) -> Iterator[Any]:
    """While a native callback blocks; gives the future of its response."""
    native.began.clear()
    native.may_end.clear()
    future = native.ask()
    assert native.began.wait(TIMEOUT_S)
    try:
        yield future
    finally:
        native.may_end.set()


@contextmanager
def hearing(backend: Ros2Backend) -> Iterator[Callable[[], None]]:
    """Topics between a publisher and a subscription of rosbase; checks that they go on."""
    heard: list[String] = []
    publisher = backend.create_publisher(String, "words", 10)
    subscription = backend.create_subscription(String, "words", heard.append, 10)

    def check() -> None:
        heard.clear()
        timer = backend.create_timer(0.02, lambda: publisher.publish(String("x")))
        spin_until(backend, lambda: len(heard) > 3)
        backend.destroy_timer(timer)

    check()
    yield check
    check()
    backend.destroy_publisher(publisher)
    backend.destroy_subscription(subscription)


def names_of_threads() -> list[str]:
    return [thread.name for thread in threading.enumerate()]


@contextmanager
def on_thread(function: Callable[[], object]) -> Iterator[threading.Thread]:
    """Runs a function on a thread, which has ended afterwards."""
    thread = threading.Thread(target=function)
    thread.start()
    yield thread
    thread.join(TIMEOUT_S)
    assert not thread.is_alive()


def test_a_callback_that_blocks_stops_nothing_of_rosbase(
    backend: Ros2Backend, context: Any
) -> None:
    native = Native(backend)
    backend.declare_parameter(ParameterSpec("rate", 1.0))
    tool = ParameterTool(context, "test_node")
    try:
        with hearing(backend) as check, blocked(native) as future:
            check()
            results: list[Any] = []
            with on_thread(lambda: results.append(tool.set("rate", "2.0"))) as thread:
                spin_until(backend, lambda: not thread.is_alive())
            assert results[0].successful
            assert not future.done()
        wait_until(future.done, "the response")
    finally:
        tool.destroy()


def test_a_callback_that_blocks_does_not_stop_the_simulated_clock(
    backend: Ros2Backend, context: Any
) -> None:
    native = Native(backend)
    simulation: Any = rclpy.create_node("simulation", context=context)
    clock = simulation.create_publisher(Clock, "/clock", 10)
    message = Clock()
    message.clock.sec = 1234
    with blocked(native):
        backend.node.set_parameters([RosParameter("use_sim_time", value=True)])

        def is_heard() -> bool:
            clock.publish(message)
            return backend.clock.now_ns() == 1234 * 10**9

        wait_until(is_heard, "the simulated time")
    simulation.destroy_node()


def test_threads_exist_only_while_there_is_something_native(opened: Open) -> None:
    backend = opened()
    with hearing(backend):
        assert "rclpy-native" not in names_of_threads()
    native = Native(backend)
    assert backend.node.executor.spin_until_future_complete(native.ask(), TIMEOUT_S) is None
    # One waits, and others run callbacks.
    assert names_of_threads().count("rclpy-native") == 1
    assert "rclpy-native-worker" in names_of_threads()
    backend.close()
    assert not [name for name in names_of_threads() if name.startswith("rclpy")]


STUCK = """
import warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
import threading
from rosbase import BaseManager

manager = BaseManager(backend="ros2")
node = manager.backend.node

def block():
    print("blocking", flush=True)
    threading.Event().wait()

node.create_timer(0.01, block)
node.executor.create_task(block)
manager.start_main_loop_timer()
print("returned", flush=True)
"""


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_callbacks_that_never_end_do_not_hold_up_the_end(signum: int, tmp_path: Path) -> None:
    with running(tmp_path, STUCK) as program:
        program.read_until("blocking")
        program.read_until("blocking")
        took_s, status, out, err = program.stop(signum)
    assert (status, out, err) == (0, "returned\n", "")
    # Two seconds are promised; busy machines need more.
    assert took_s < 5.0


def test_callbacks_of_one_group_run_one_after_the_other_and_others_in_parallel(
    backend: Ros2Backend,
) -> None:
    most: dict[str, int] = {}
    lock = threading.Lock()

    def run(group: str, now: dict[str, int]) -> None:
        with lock:
            now[group] = now.get(group, 0) + 1
            most[group] = max(most.get(group, 0), now[group])
        time.sleep(0.005)
        with lock:
            now[group] -= 1

    now: dict[str, int] = {}
    groups = {
        "default": None,
        "exclusive": MutuallyExclusiveCallbackGroup(),
        "reentrant": ReentrantCallbackGroup(),
    }
    for name, group in groups.items():
        for _ in range(3):
            backend.node.create_timer(0.002, lambda n=name: run(n, now), group)
    wait_until(lambda: most.get("reentrant", 0) > 1, "two at a time")
    assert (most["default"], most["exclusive"]) == (1, 1)


def test_a_coroutine_awaits_what_other_callbacks_bring(backend: Ros2Backend) -> None:
    native = Native(backend)
    answers: list[bool] = []

    async def ask() -> None:
        timer.cancel()
        for _ in range(20):
            answers.append((await native.ask()).successful)

    timer = backend.node.create_timer(0.001, ask, ReentrantCallbackGroup())
    wait_until(lambda: len(answers) == 20, "all answers")
    assert all(answers)


def test_a_coroutine_goes_on_after_a_task_that_ends_while_it_waits(backend: Ros2Backend) -> None:
    executor = backend.node.executor
    for _ in range(20):
        is_waiting, may_end = threading.Event(), threading.Event()
        work = executor.create_task(may_end.wait, TIMEOUT_S)

        async def wait_for(work: Any, is_waiting: threading.Event) -> bool:
            is_waiting.set()
            return bool(await work)

        waiting = executor.create_task(wait_for, work, is_waiting)
        assert is_waiting.wait(TIMEOUT_S)
        may_end.set()
        wait_until(waiting.done, "the end of the coroutine")
        assert waiting.result() is True


def test_what_a_callback_raises_is_logged_and_the_next_one_runs(
    backend: Ros2Backend, caplog: pytest.LogCaptureFixture
) -> None:
    def fail(error: BaseException) -> None:
        raise error

    for error in (ValueError("no cup"), SystemExit(3), KeyboardInterrupt()):
        backend.node.executor.create_task(fail, error)
    wait_until(lambda: len(caplog.messages) == 3, "three lines")
    assert sorted(caplog.messages) == [
        "a callback of rclpy raised KeyboardInterrupt: ",
        "a callback of rclpy raised SystemExit: 3",
        "a callback of rclpy raised ValueError: no cup",
    ]
    native = Native(backend)
    wait_until(native.ask().done, "the response")


def test_parameters_that_a_native_callback_sets_are_checked_on_the_main_loop(
    backend: Ros2Backend,
) -> None:
    asked: list[threading.Thread] = []

    def note(parameters: list[Parameter[Any]]) -> SetParametersResult:
        asked.append(threading.current_thread())
        return SetParametersResult(successful=True)

    backend.declare_parameter(ParameterSpec("rate", 1.0))
    backend.add_on_set_parameters_callback(note)
    parameters = [RosParameter("rate", value=2.0)]
    task = backend.node.executor.create_task(backend.node.set_parameters, parameters)
    spin_until(backend, task.done)
    assert asked == [threading.current_thread()]
    assert backend.get_parameter("rate").value == 2.0


def test_an_action_runs_beside_everything_else_and_can_be_cancelled(backend: Ros2Backend) -> None:
    may_end = threading.Event()

    def execute(goal: Any) -> Any:
        while not may_end.wait(0.01):
            if goal.is_cancel_requested:
                goal.canceled()
                return Fibonacci.Result()
        goal.succeed()
        return Fibonacci.Result(sequence=[goal.request.order])

    def accept(goal: Any) -> CancelResponse:
        return CancelResponse.ACCEPT

    server = ActionServer(backend.node, Fibonacci, "count", execute, cancel_callback=accept)
    client = ActionClient(backend.node, Fibonacci, "count")
    assert client.wait_for_server(TIMEOUT_S)

    def complete(future: Any) -> Any:
        rclpy.spin_until_future_complete(backend.node, future, timeout_sec=TIMEOUT_S)
        return future.result()

    with hearing(backend) as check:
        first, second = (complete(client.send_goal_async(Fibonacci.Goal(order=n))) for n in (1, 2))
        check()
        assert len(complete(first.cancel_goal_async()).goals_canceling) == 1
        assert complete(first.get_result_async()).status == GoalStatus.STATUS_CANCELED
        check()
        may_end.set()
        assert list(complete(second.get_result_async()).result.sequence) == [2]
    server.destroy()
    client.destroy()


# The program spins the node itself.


def until_complete(node: Any, future: Any) -> None:
    rclpy.spin_until_future_complete(node, future, timeout_sec=TIMEOUT_S)


def until_complete_without_a_limit(node: Any, future: Any) -> None:
    rclpy.spin_until_future_complete(node, future)


def once_again_and_again(node: Any, future: Any) -> None:
    while not future.done():
        rclpy.spin_once(node)


def once_with_a_limit(node: Any, future: Any) -> None:
    while not future.done():
        rclpy.spin_once(node, timeout_sec=0.05)


def the_executor_of_the_node(node: Any, future: Any) -> None:
    node.executor.spin_until_future_complete(future)


def once_on_the_executor_of_the_node(node: Any, future: Any) -> None:
    while not future.done():
        node.executor.spin_once(0.05)


def executor_of(kind: Any, *, is_default: bool = False) -> Callable[[Any, Any], None]:
    def spin(node: Any, future: Any) -> None:
        executor = kind(context=None if is_default else node.context)
        executor.add_node(node)
        executor.spin_until_future_complete(future, TIMEOUT_S)
        executor.remove_node(node)
        executor.shutdown()

    return spin


SPINS = {
    "until": until_complete,
    "until, without a limit": until_complete_without_a_limit,
    "once": once_again_and_again,
    "once, with a limit": once_with_a_limit,
    "of the node": the_executor_of_the_node,
    "once, of the node": once_on_the_executor_of_the_node,
    "single": executor_of(SingleThreadedExecutor),
    "multi": executor_of(MultiThreadedExecutor),
    "events": executor_of(EventsExecutor),
    "single, default": executor_of(SingleThreadedExecutor, is_default=True),
}


@pytest.mark.parametrize("is_initialised", [False, True], ids=["", "init"])
@pytest.mark.parametrize("way", SPINS)
def test_a_program_may_spin_the_node_and_rosbase_goes_on_during_and_after(
    way: str, is_initialised: bool, opened: Open
) -> None:
    if is_initialised:
        rclpy.init(args=[])
    backend = opened()
    native = Native(backend)
    spin = SPINS[way]
    with hearing(backend) as check:
        for _ in range(20):
            future = native.ask()
            spin(backend.node, future)
            assert future.result().successful
        check()
        # On another thread, and longer.
        with blocked(native) as future, on_thread(lambda: spin(backend.node, future)):
            check()
            native.may_end.set()
        assert future.result().successful
        check()
        later = native.ask()
        wait_until(later.done, "what is native goes on too")
    backend.close()
    assert rclpy.ok() == is_initialised
    if is_initialised:
        rclpy.shutdown()


def test_a_handler_of_rosbase_may_wait_for_a_service_on_the_main_loop(
    backend: Ros2Backend,
) -> None:
    native = Native(backend)
    answers: list[bool] = []

    def ask(message: String) -> None:
        future = native.ask()
        rclpy.spin_until_future_complete(backend.node, future)
        answers.append(future.result().successful)

    backend.create_subscription(String, "questions", ask, 10)
    publisher = backend.create_publisher(String, "questions", 10)
    backend.create_timer(0.02, lambda: publisher.publish(String("?")))
    spin_until(backend, lambda: len(answers) > 5)
    assert all(answers)


def test_a_native_callback_may_wait_for_another_in_another_group(backend: Ros2Backend) -> None:
    native = Native(backend, ReentrantCallbackGroup())
    answers: list[bool] = []

    def ask() -> None:
        timer.cancel()
        answers.append(native.client.call(Service.Request()).successful)
        future = native.ask()
        rclpy.spin_until_future_complete(backend.node, future)
        answers.append(future.result().successful)

    timer = backend.node.create_timer(0.001, ask)
    wait_until(lambda: len(answers) == 2, "both answers")
    assert all(answers)


def test_spin_once_returns_after_one_callback_or_its_time(backend: Ros2Backend) -> None:
    before_s = time.monotonic()
    rclpy.spin_once(backend.node, timeout_sec=0.0)
    rclpy.spin_once(backend.node, timeout_sec=0.1)
    rclpy.spin_once(backend.node, timeout_sec=0.1)
    assert 0.1 < time.monotonic() - before_s < TIMEOUT_S
    ticks: list[int] = []
    backend.node.create_timer(0.05, lambda: ticks.append(0))
    for _ in range(5):
        rclpy.spin_once(backend.node)
    assert 4 <= len(ticks) <= 6


def test_an_executor_that_has_the_node_and_does_not_spin_collects_nothing(
    backend: Ros2Backend,
) -> None:
    ticks: list[int] = []
    executor = SingleThreadedExecutor(context=backend.node.context)
    executor.add_node(backend.node)
    backend.node.create_timer(0.001, lambda: ticks.append(0))
    wait_until(lambda: len(ticks) > 50, "many callbacks")
    turns = 0
    while True:
        before = len(ticks)
        executor.spin_once(timeout_sec=0.0)
        turns += 1
        if len(ticks) == before:
            break
    assert turns < 10
    executor.shutdown()


def test_rclpy_spin_serves_the_node_until_rclpy_is_shut_down(opened: Open) -> None:
    backend = opened()
    ends: list[type[BaseException] | None] = []

    def spin() -> None:
        try:
            rclpy.spin(backend.node)
        except BaseException as error:
            ends.append(type(error))
        else:
            ends.append(None)

    with hearing(backend) as check, on_thread(spin):
        native = Native(backend)
        wait_until(native.ask().done, "the response")
        check()
        rclpy.shutdown()
    # As with any node; `while rclpy.ok()` sees it first.
    assert ends[0] in (None, rclpy.executors.ExternalShutdownException)


def test_entities_of_rosbase_and_of_the_program_are_told_apart(backend: Ros2Backend) -> None:
    assert backend.node.native.is_empty
    backend.create_subscription(String, "words", print, 10)
    backend.node.set_parameters([RosParameter("use_sim_time", value=True)])
    assert backend.node.native.is_empty
    backend.node.create_subscription(RosString, "words", lambda message: None, 10)
    assert {end.topic_name for end in backend.node.native.subscriptions} == {"/words"}
    assert {end.topic_name for end in backend.node.own.subscriptions} == {"/words", "/clock"}
    assert len(list(backend.node.own.services)) == 7


# The default context of rclpy.


def test_rclpy_is_initialised_as_long_as_a_backend_is_open() -> None:
    assert not rclpy.ok()
    one, other = (Ros2Backend(BackendOptions(name)) for name in ("one", "other"))
    assert rclpy.ok()
    one.close()
    native = Native(other)
    until_complete(other.node, native.ask())
    other.close()
    assert not rclpy.ok()
    again = Ros2Backend(BackendOptions("again"))
    assert rclpy.ok()
    again.close()
    assert not rclpy.ok()


@pytest.mark.parametrize("is_spun", [False, True], ids=["", "spun"])
def test_a_programs_own_init_may_come_later(is_spun: bool, opened: Open) -> None:
    backend = opened("-r", "hand_written:__node:=renamed")
    native = Native(backend)
    if is_spun:
        until_complete(backend.node, native.ask())
    rclpy.init(args=["program", "--ros-args", "-r", "__ns:=/robot"], domain_id=7)
    assert rclpy.get_default_context().get_domain_id() == 7
    node: Any = rclpy.create_node("hand_written")
    assert node.get_fully_qualified_name() == "/robot/hand_written"
    future = native.ask()
    until_complete(backend.node, future)
    assert future.done()
    node.destroy_node()
    with pytest.raises(RuntimeError, match="only be called once"):
        rclpy.init()
    rclpy.shutdown()
    with hearing(backend):
        pass
    rclpy.init(args=[])
    backend.close()
    assert rclpy.ok(), "it is the program's"
    rclpy.shutdown()


def test_nodes_of_the_program_need_no_init(opened: Open) -> None:
    opened()
    node: Any = rclpy.create_node("second")
    ticks: list[int] = []
    node.create_timer(0.01, lambda: ticks.append(0))
    rclpy.spin_once(node)
    assert ticks == [0]
    node.destroy_node()


def test_a_name_on_the_command_line_is_not_that_of_the_programs_own_nodes(opened: Open) -> None:
    backend = opened("-r", "__node:=eve", "-r", "__ns:=/robot")
    node: Any = rclpy.create_node("second")
    assert node.get_fully_qualified_name() == "/robot/second"
    assert backend.node.get_fully_qualified_name() == "/robot/eve"
    node.destroy_node()


@pytest.mark.parametrize("is_programs", [True, False], ids=["its own", "a lent one"])
def test_a_backend_opens_after_a_default_context_that_has_ended(is_programs: bool) -> None:
    first = None if is_programs else Ros2Backend(BackendOptions("first"))
    if is_programs:
        rclpy.init(args=[])
    # As the signal handlers of rclpy do it: the default context stays, and is dead.
    rclpy.get_default_context().shutdown()
    assert not rclpy.ok()
    backend = Ros2Backend(BackendOptions("second"))
    assert rclpy.ok()
    backend.close()
    if first is not None:
        first.close()
    assert not rclpy.ok()


def test_a_program_that_spins_the_executor_of_the_node_ends_with_it() -> None:
    backend = Ros2Backend(BackendOptions("spun"))
    executor = backend.node.executor
    ended: list[bool] = []

    def spin() -> None:
        executor.spin_once(timeout_sec=-1.0)
        ended.append(True)

    thread = threading.Thread(target=spin)
    thread.start()
    backend.close()
    thread.join(TIMEOUT_S)
    assert ended == [True]


def test_callbacks_for_events_may_serve_several_topics(backend: Ros2Backend) -> None:
    events = PublisherEventCallbacks()
    for topic in ("one", "other"):
        backend.node.create_publisher(RosString, topic, 10, event_callbacks=events)
    assert events.incompatible_qos is None
