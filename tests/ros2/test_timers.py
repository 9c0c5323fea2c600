"""Timers over `use_sim_time`: on the machine's clock, on `/clock`, and from one to the other."""

import itertools
import math
from collections.abc import Callable
from typing import Any

import pytest
import rclpy
from rclpy.clock import ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter_client import AsyncParameterClient
from rclpy.time import Time as RclpyTime
from rosgraph_msgs.msg import Clock as ClockMessage

from rosbase import BaseNode
from rosbase.contracts.backend import BackendOptions, Timer
from rosbase.messages import Time, Vector3
from rosbase_ros2.backend import Ros2Backend
from support.ros import TIMEOUT_S, spin_until

PERIOD_S = 0.005
START_S = 1000.0


@pytest.fixture
def simulated(backend: Ros2Backend) -> Ros2Backend:
    """A backend on a `/clock` that says 1000 s."""
    switch(backend, on=True)
    set_clock(backend, START_S)
    return backend


def switch(backend: Ros2Backend, *, on: bool) -> None:
    """What the service does that sets parameters."""
    parameter = rclpy.Parameter("use_sim_time", value=on)
    assert backend.node.set_parameters([parameter])[0].successful


def set_clock(backend: Ros2Backend, seconds: float) -> None:
    """What rclpy does with a message on `/clock`."""
    time: Any = RclpyTime(nanoseconds=int(seconds * 1e9), clock_type=ClockType.ROS_TIME)
    backend.node.get_clock().set_ros_time_override(time)


def let_time_pass(backend: Ros2Backend) -> None:
    """Runs the main loop for some periods of the machine's clock, and all that is queued."""
    ticks: list[int] = []
    timer = backend.executor.create_timer(int(PERIOD_S * 1e9), lambda: ticks.append(1))
    spin_until(backend, lambda: len(ticks) >= 5)
    timer.destroy()


def calls_at(backend: Ros2Backend, calls: list[int], *seconds: float) -> list[int]:
    """How many calls each new time of `/clock` leads to."""
    counts = []
    for time_s in seconds:
        before = len(calls)
        set_clock(backend, time_s)
        let_time_pass(backend)
        counts.append(len(calls) - before)
    return counts


def test_a_timer_follows_the_clock_topic_from_a_service_call_on_and_the_machine_after_the_next(
    backend: Ros2Backend, context: Any
) -> None:
    node: Any = rclpy.create_node("simulation", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    clocks = node.create_publisher(ClockMessage, "/clock", 10)
    client = AsyncParameterClient(node, "test_node")
    assert client.wait_for_services(TIMEOUT_S)

    def set_use_sim_time(value: bool) -> None:
        future = client.set_parameters([rclpy.Parameter("use_sim_time", value=value)])
        executor.spin_until_future_complete(future, TIMEOUT_S)
        assert future.result().results[0].successful

    fired: list[Time] = []
    seconds = itertools.count(100)

    def has_fired_simulated() -> bool:
        message = ClockMessage()
        message.clock.sec = next(seconds)
        clocks.publish(message)
        return len(fired) >= 4

    timer = backend.create_timer(10.0, lambda: fired.append(backend.clock.now()))
    set_use_sim_time(True)
    heartbeat = backend.executor.create_timer(10_000_000, lambda: None)
    spin_until(backend, has_fired_simulated)
    heartbeat.destroy()
    # Ten seconds of the simulation each, in far less than ten of ours.
    assert all(b.sec - a.sec >= 9 for a, b in itertools.pairwise(fired))
    assert fired[-1].sec < 1_000_000
    backend.destroy_timer(timer)

    now: list[Time] = []
    backend.create_timer(PERIOD_S, lambda: now.append(backend.clock.now()))
    set_use_sim_time(False)
    spin_until(backend, lambda: len(now) >= 3)
    assert now[-1].sec > 1_000_000
    executor.shutdown()
    node.destroy_node()


def test_use_sim_time_from_the_start_has_timers_follow_the_clock() -> None:
    backend = Ros2Backend(BackendOptions("simulated", {"use_sim_time": True}))
    try:
        calls: list[int] = []
        backend.create_timer(PERIOD_S, lambda: calls.append(1))
        assert calls_at(backend, calls, START_S, START_S + PERIOD_S) == [0, 1]
    finally:
        backend.close()


def test_a_timer_stands_still_while_the_simulation_does(simulated: Ros2Backend) -> None:
    calls: list[int] = []
    simulated.create_timer(PERIOD_S, lambda: calls.append(1))
    let_time_pass(simulated)
    assert not calls
    assert calls_at(simulated, calls, START_S + PERIOD_S, START_S + PERIOD_S) == [1, 0]


def test_a_timer_from_before_the_switch_follows_it_there_and_back(backend: Ros2Backend) -> None:
    calls: list[int] = []
    backend.create_timer(PERIOD_S, lambda: calls.append(1))
    let_time_pass(backend)
    assert calls
    calls.clear()
    switch(backend, on=True)
    let_time_pass(backend)
    assert not calls
    assert calls_at(backend, calls, START_S, START_S + PERIOD_S) == [0, 1]
    switch(backend, on=False)
    spin_until(backend, lambda: len(calls) >= 3)


def test_the_first_call_is_one_period_after_the_clock_is_found(backend: Ros2Backend) -> None:
    calls: list[int] = []
    for first_s in (START_S, 50 * START_S):
        switch(backend, on=True)
        timer = backend.create_timer(1.0, lambda: calls.append(1))
        assert calls_at(backend, calls, first_s, first_s + 0.9, first_s + 1.0) == [0, 0, 1]
        backend.destroy_timer(timer)
        switch(backend, on=False)


def test_a_clock_that_jumps_makes_no_burst(simulated: Ros2Backend) -> None:
    calls: list[int] = []
    simulated.create_timer(1.0, lambda: calls.append(1))
    steps = (100.5, 100.6, 101.0, -500.0, -499.5, -499.0)
    times = [START_S + step for step in steps]
    assert calls_at(simulated, calls, *times) == [1, 0, 1, 0, 0, 1]


def test_a_busy_main_loop_finds_one_call_of_a_simulated_timer(simulated: Ros2Backend) -> None:
    calls: list[int] = []
    simulated.create_timer(1.0, lambda: calls.append(1))
    for second in range(1, 20):
        set_clock(simulated, START_S + second)
    let_time_pass(simulated)
    assert calls == [1]


@pytest.mark.parametrize("on", [True, False])
def test_a_cancelled_timer_stays_cancelled_over_the_switch(backend: Ros2Backend, on: bool) -> None:
    switch(backend, on=not on)
    calls: list[int] = []
    timer = backend.create_timer(PERIOD_S, lambda: calls.append(1))
    timer.cancel()
    switch(backend, on=on)
    assert timer.is_canceled()
    assert calls_at(backend, calls, START_S, START_S + 1.0) == [0, 0]
    timer.reset()
    assert not timer.is_canceled()
    calls_at(backend, calls, START_S + 2.0)
    assert calls


ENDS: dict[str, Callable[[Ros2Backend, Timer], object]] = {
    "cancelled": lambda backend, timer: timer.cancel(),
    "reset": lambda backend, timer: timer.reset(),
    "destroyed": lambda backend, timer: backend.destroy_timer(timer),
    "switched off": lambda backend, timer: switch(backend, on=False),
    "closed": lambda backend, timer: backend.close(),
}


@pytest.mark.parametrize("end", ENDS.values(), ids=ENDS.keys())
def test_a_call_that_is_queued_is_not_made_once_its_timer_was_stopped(
    simulated: Ros2Backend, end: Callable[[Ros2Backend, Timer], object]
) -> None:
    calls: list[int] = []
    timer = simulated.create_timer(1000.0, lambda: calls.append(1))
    set_clock(simulated, START_S + 1000.0)
    assert simulated.executor.ready
    end(simulated, timer)
    while simulated.spin_once(0):
        pass
    assert not calls


@pytest.mark.parametrize("on", [True, False])
def test_a_destroyed_timer_does_not_start_again(backend: Ros2Backend, on: bool) -> None:
    switch(backend, on=on)
    calls: list[int] = []
    timer = backend.create_timer(PERIOD_S, lambda: calls.append(1))
    backend.destroy_timer(timer)
    backend.destroy_timer(timer)
    timer.reset()
    assert timer.is_canceled()
    assert calls_at(backend, calls, START_S, START_S + 1.0) == [0, 0]


@pytest.mark.parametrize("on", [True, False])
@pytest.mark.parametrize("period_s", [0, -1.0, float("nan"), float("inf")])
def test_a_period_that_is_none_is_refused_by_either_clock(
    backend: Ros2Backend, on: bool, period_s: float
) -> None:
    switch(backend, on=on)
    with pytest.raises(ValueError, match="a positive number of seconds"):
        backend.create_timer(period_s, print)


def test_on_the_machines_clock_the_executor_itself_calls_back(backend: Ros2Backend) -> None:
    def callback() -> None: ...

    backend.create_timer(1.0, callback)
    assert [timer.callback for _, _, timer in backend.executor.timers] == [callback] * 2


# Nobody publishes `/clock`.

NOBODY = "use_sim_time is true and nothing publishes /clock: stamps are zero and timers stand still"


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rosbase_ros2.sim_time._PATIENCE_S", 0.05)


def warnings_of(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [record.getMessage().partition(" until")[0] for record in caplog.records]


def test_a_clock_that_nobody_publishes_is_said_once(
    impatient: None, caplog: pytest.LogCaptureFixture
) -> None:
    backend = Ros2Backend(BackendOptions("simulated", {"use_sim_time": True}))
    try:
        spin_until(backend, lambda: warnings_of(caplog))
        switch(backend, on=False)
        switch(backend, on=True)
        for _ in range(5):
            let_time_pass(backend)
        assert warnings_of(caplog) == [NOBODY]
    finally:
        backend.close()


def test_it_is_said_too_when_use_sim_time_is_set_later(
    impatient: None, backend: Ros2Backend, caplog: pytest.LogCaptureFixture
) -> None:
    for _ in range(5):
        let_time_pass(backend)
    assert warnings_of(caplog) == []
    switch(backend, on=True)
    spin_until(backend, lambda: warnings_of(caplog))
    assert warnings_of(caplog) == [NOBODY]


def test_nothing_is_said_of_a_clock_that_somebody_publishes(
    impatient: None, backend: Ros2Backend, context: Any, caplog: pytest.LogCaptureFixture
) -> None:
    simulator: Any = rclpy.create_node("simulator", context=context)
    simulator.create_publisher(ClockMessage, "/clock", 1)
    spin_until(backend, lambda: backend.node.count_publishers("/clock"))
    switch(backend, on=True)
    for _ in range(5):
        let_time_pass(backend)
    simulator.destroy_node()
    # It is looked for again the next time.
    switch(backend, on=False)
    spin_until(backend, lambda: not backend.node.count_publishers("/clock"))
    switch(backend, on=True)
    spin_until(backend, lambda: warnings_of(caplog))
    assert warnings_of(caplog) == [NOBODY]


def test_the_age_of_the_latest_message_follows_the_clock_too(simulated: Ros2Backend) -> None:
    node = BaseNode(backend=simulated)
    force, publisher = node.latest(Vector3, "force"), node.create_publisher(Vector3, "force")

    def has_arrived() -> bool:
        publisher.publish(Vector3(x=1.0))
        return force.value is not None

    heartbeat = simulated.executor.create_timer(10_000_000, lambda: None)
    spin_until(simulated, has_arrived)
    heartbeat.destroy()
    node.destroy_subscription(force.subscription)
    assert force.age_s == 0.0
    set_clock(simulated, START_S + 2.5)
    assert force.age_s == 2.5
    assert not force.is_fresh(2.0)
    set_clock(simulated, 0.0)
    assert force.age_s == math.inf
