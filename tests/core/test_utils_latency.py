"""`rosbase.utils.profile_latency`, in virtual time."""

import inspect
from collections.abc import Iterator
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, BaseNode, RosbaseLogger
from rosbase.messages import Header, Imu, Time
from rosbase.testing import ManualClock, virtual_backend
from rosbase.utils import profile_latency


@pytest.fixture
def clock() -> ManualClock:
    return ManualClock()


@pytest.fixture
def log(caplog: pytest.LogCaptureFixture) -> pytest.LogCaptureFixture:
    caplog.set_level("DEBUG", logger="rosbase")
    return caplog


def test_each_interval_has_a_line_with_mean_percentiles_and_maximum(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    @profile_latency(log_interval_s=1.0, clock=clock, logger=RosbaseLogger("x"))
    def work(seconds: float) -> None:
        clock.advance(seconds)

    # 100 calls, each 10 ms after the last; one takes longer.
    for number in range(101):
        taken = 0.008 if number == 50 else 0.002
        work(taken)
        clock.advance(0.01 - taken)
    # A percentile is at most 1/32 off.
    assert log.messages == [
        "work: cycle 10.000 ms (p50 10.000, p99 10.000, max 10.000);"
        " process 2.059 ms (p50 2.032, p99 2.032, max 8.000)"
    ]


def test_the_first_call_beyond_a_threshold_is_named_and_the_others_counted(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    @profile_latency(50, 20, log_interval_s=1.0, clock=clock, logger=RosbaseLogger("x"))
    def work(seconds: float) -> None:
        clock.advance(seconds)

    for seconds in (0.01, 0.03, 0.03, 0.01):
        work(seconds)
    clock.advance(0.1)
    work(0.01)
    assert log.messages == [
        "work: process took 30.000 ms, more than 20",
        "work: cycle took 110.000 ms, more than 50",
    ]
    assert {record.levelname for record in log.records} == {"WARNING"}
    clock.advance(1.0)
    work(0.01)
    assert "2 over 50" in log.messages[-1]
    assert "max 30.000, 2 over 20" in log.messages[-1]
    assert log.records[-1].levelname == "INFO"
    # The next interval begins anew.
    work(0.03)
    assert log.messages[-1] == "work: process took 30.000 ms, more than 20"


def test_many_calls_within_an_interval_are_all_counted(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    @profile_latency(8, 20, log_interval_s=15.0, clock=clock, logger=RosbaseLogger("x"))
    def work(seconds: float) -> None:
        clock.advance(seconds)

    # Every tenth call takes 10 ms, and the next one is late.
    for number in range(7_899):
        work(0.01 if number % 10 == 9 else 0.001)
    warning, line = log.messages
    assert warning == "work: cycle took 10.000 ms, more than 8"
    # 789 times ten calls take 14.991 s.
    assert line.startswith("work: cycle 1.899 ms (p50 1.0")
    assert "max 10.000, 789 over 8); process 1.899 ms" in line


def test_each_object_is_measured_on_its_own(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    class Camera:
        def __init__(self, name: str) -> None:
            self.logger = RosbaseLogger(name)

        @profile_latency(50, log_interval_s=10.0, clock=clock)
        def keep(self) -> str:
            return self.logger.name

    left, right = Camera("left"), Camera("right")
    assert [left.keep(), right.keep()] == ["left", "right"]
    clock.advance(0.1)
    left.keep()
    assert [record.name for record in log.records] == ["rosbase.left"]
    assert log.messages == ["Camera.keep: cycle took 100.000 ms, more than 50"]


def test_an_object_that_is_gone_leaves_nothing_to_the_next_of_its_id(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    class Agent:
        @profile_latency(50, clock=clock)
        def compute(self) -> None: ...

    for _ in range(100):
        Agent().compute()
        clock.advance(1.0)
    assert log.messages == []


def test_the_age_of_a_message_is_that_of_its_stamp_when_the_call_begins(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    @profile_latency(
        1e6, 1e6, 1.0, check_capture_latency=True, clock=clock, logger=RosbaseLogger("x")
    )
    def keep(message: Imu) -> None:
        clock.advance(0.5)

    for age_ns in (10_000_000, 30_000_000):
        keep(Imu(header=Header(stamp=Time.as_stamp(clock.now_ns() - age_ns))))
    (line,) = log.messages
    assert "age of the stamp 20.000 ms" in line
    # Without a stamp, there is no age.
    clock.advance(1.0)
    keep(Imu())
    assert "age" not in log.messages[-1]


def test_handlers_nodes_and_agents_are_measured_in_the_virtual_time_of_their_manager(
    log: pytest.LogCaptureFixture,
) -> None:
    class Camera(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.create_timer(0.25, self.look)

        @profile_latency(cycle_threshold_ms=1000, log_interval_s=10)
        def look(self) -> None: ...

    class Handlers(BaseHandlers):
        @profile_latency(cycle_threshold_ms=1000, log_interval_s=10)
        def handle(self) -> None:
            if self.timestamp == 120:
                self.manager.request_stop()

    manager = BaseManager(
        "boss", {"eye": Camera}, handlers_class=Handlers, node_freq_hz=10, backend=virtual_backend()
    )
    manager.start_main_loop_timer()
    lines = sorted((record.name, record.getMessage()) for record in log.records)
    assert [(name, line.split(" (")[0]) for name, line in lines] == [
        ("rosbase.boss", "Handlers.handle: cycle 100.000 ms"),
        ("rosbase.boss.eye", "Camera.look: cycle 250.000 ms"),
    ]


def test_the_function_keeps_its_result_its_exception_its_name_and_its_signature(
    clock: ManualClock,
) -> None:
    @profile_latency
    def divide(a: float, b: float = 2.0) -> float:
        """Divide."""
        return a / b

    assert divide(4.0) == 2.0
    assert divide(4.0, b=1.0) == 4.0
    with pytest.raises(ZeroDivisionError):
        divide(1.0, 0.0)
    assert (divide.__name__, divide.__doc__) == ("divide", "Divide.")
    assert list(inspect.signature(divide).parameters) == ["a", "b"]


def test_a_call_that_raises_is_measured_too(
    clock: ManualClock, log: pytest.LogCaptureFixture
) -> None:
    @profile_latency(clock=clock, logger=RosbaseLogger("x"))
    def fail() -> None:
        clock.advance(0.1)
        raise ConnectionResetError

    with pytest.raises(ConnectionResetError):
        fail()
    assert log.messages == ["fail: process took 100.000 ms, more than 20"]


def test_without_debug_the_function_is_returned_as_it_is() -> None:
    def work() -> None: ...

    assert profile_latency(debug=False)(work) is work


def test_a_node_with_getattr_is_not_asked_for_what_does_not_exist(clock: ManualClock) -> None:
    class Odd:
        def __getattr__(self, name: str) -> Any:
            raise AssertionError(f"asked for {name}")

        @profile_latency
        def work(self) -> None: ...

    Odd().work()


def test_objects_without_room_for_a_weak_reference_can_be_measured() -> None:
    class Slots:
        __slots__ = ()

        @profile_latency
        def work(self) -> int:
            return 1

    assert Slots().work() == 1


def test_what_does_not_run_when_it_is_called_is_refused() -> None:
    async def later() -> None: ...

    def generate() -> Iterator[int]:
        yield 1

    for function in (later, generate):
        with pytest.raises(TypeError, match="profile_latency cannot measure"):
            profile_latency(function)
