"""The reader on ROS 2, on a machine whose date ROS or DDS cannot carry."""

import logging
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from diagnostic_msgs.msg import DiagnosticArray
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile

from imu_serial.simulator import PtyDevice
from rosbase import (
    BackendError,
    BackendOptions,
    LifecycleNode,
    ParameterError,
    ParameterKind,
    ParameterSpec,
    make_logger,
)
from rosbase.imu.outlet import VARYING
from rosbase.messages import Header, Imu
from rosbase.testing import ManualClock
from rosbase_ros2 import clock, refusals, starting
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.conversion import Conversions
from rosbase_ros2.courier import courier_of
from rosbase_ros2.machine import date_refusal
from rosbase_ros2.refusals import RCLError, Refusals
from rosbase_ros2.topics import RosPublisher
from support.command import ROSBASE, RunningRosbase, summary_of
from support.faketime import FakeDate, needs_faketime
from support.listening import Listener, listening
from support.ros import Client, Served
from support.streaming import streaming
from support.waiting import wait_until

S = 1_000_000_000
NOW_NS = 1_800_000_000 * S
Y1969_NS = -18_489_600 * S
# Less what libfaketime may be off.
Y2030_S = 1_893_456_000 - 10
Y2035_S = 2_051_222_400 - 10
Y2040_NS = 2_208_988_800 * S
Y2110_NS = 4_417_977_600 * S
FASTDDS = "rmw_fastrtps_cpp"


@pytest.fixture
def device() -> Iterator[PtyDevice]:
    device = PtyDevice()
    with streaming(device):
        yield device


def imu_at(date: FakeDate, device: PtyDevice) -> RunningRosbase:
    """The reader on that device, at that date."""
    # rclpy checks its own stamps where this is 1, and raises at a date that is none.
    checks = {"ROS_PYTHON_CHECK_FIELDS": "0"}
    path = device.parameters["device_path"]
    command = date.command(
        ROSBASE, "imu", "--backend", "ros2", "-p", f"device_path:={path}", **checks
    )
    return RunningRosbase(*command[1:], program=command[0])


def seconds(listener: Listener) -> list[int]:
    """The seconds of the stamps that were heard."""
    return [message["stamp"][0] for message in listener.heard]


def last_health(reader: RunningRosbase) -> str:
    """The last line of the log about the health."""
    return next((line for line in reversed(reader.err.lines) if "]: health " in line), "")


def end(reader: RunningRosbase) -> int:
    """The status, if the end was bounded and without a traceback."""
    start_s = time.monotonic()
    status = reader.end(signal.SIGINT)
    # At such a date rclpy itself takes its time.
    assert time.monotonic() - start_s < 15.0
    assert "Traceback" not in reader.err, reader.err.lines
    return status


@needs_faketime
@pytest.mark.timeout(150)
def test_a_subscriber_in_another_process_gets_the_samples_with_a_stamp_of_zero(
    tmp_path: Path, device: PtyDevice
) -> None:
    date = FakeDate(tmp_path, "2110-01-01 00:00:00")
    with listening() as listener, imu_at(date, device) as reader:
        wait_until(lambda: len(listener.heard) > 50, "samples", 40.0)
        reader.waits_for("health WARN: stamps are zero: the date of this machine is 2110-01-01")
        assert end(reader) == 0
    assert all(message["stamp"] == [0, 0] for message in listener.heard)
    assert listener.heard[0]["linear_acceleration"][2] == pytest.approx(9.8, abs=2.0)
    summary = summary_of(reader.out.lines)
    assert summary["clock_unusable"] == summary["published"] > 50
    assert summary["rejected"] == 0


def test_a_simulated_clock_that_nobody_publishes_is_said_and_hides_nothing(
    device: PtyDevice, context: Any
) -> None:
    heard: list[DiagnosticArray] = []
    client = Client(context, "lifecycle_manager")
    client.node.create_subscription(DiagnosticArray, "/diagnostics", heard.append, 10)
    path = device.parameters["device_path"]
    try:
        with (
            listening() as listener,
            RunningRosbase(
                "imu", "--backend", "ros2", "-p", f"device_path:={path}",
                "--ros-args", "-p", "use_sim_time:=true",
            ) as reader,
        ):  # fmt: skip
            wait_until(lambda: len(listener.heard) > 10, "samples")

            def is_said() -> bool:
                client.executor.spin_once(timeout_sec=0.01)
                return any("publish /clock?" in array.status[0].message for array in heard)

            wait_until(is_said, "diagnostics that say so")
            assert end(reader) == 0
    finally:
        client.destroy()
    assert all(message["stamp"] == [0, 0] for message in listener.heard)
    assert "health WARN: stamps are zero: the clock has no date yet" in reader.err


@needs_faketime
@pytest.mark.parametrize("date", ["2040-01-01", "1969-06-01"])
def test_a_date_at_which_dds_sends_nothing_is_one_line_before_it_starts(
    tmp_path: Path, device: PtyDevice, date: str
) -> None:
    with imu_at(FakeDate(tmp_path, f"{date} 00:00:00"), device) as reader:
        assert reader.end() == 2
    assert reader.out.lines == []
    (line,) = reader.err.lines
    assert line.startswith(f"rosbase: ROS 2 does not start: the date of this machine is {date} ")
    assert line.endswith("rmw_fastrtps_cpp sends nothing at such a date; set the clock")


@needs_faketime
@pytest.mark.timeout(150)
def test_a_clock_that_is_set_wrong_and_right_again_costs_what_was_sent_meanwhile(
    tmp_path: Path, device: PtyDevice, context: Any
) -> None:
    # Not from 1970 on: with a date in the past, libfaketime upsets the shared memory of Fast DDS.
    date = FakeDate(tmp_path, "2030-01-01 00:00:00")
    client = Client(context, "lifecycle_manager")
    try:
        with listening() as listener, imu_at(date, device) as reader:
            wait_until(lambda: seconds(listener), "a stamp of 2030", 40.0)
            date.set("2040-01-01 00:00:00")
            wait_until(lambda: "2040-01-01" in last_health(reader), "the health to name the date")
            reader.waits_for("ROS does not send messages, on /imu/data or elsewhere: the date")
            # Whoever asks for its state has an answer all the same.
            assert client.state() == "active"
            date.set("2035-01-01 00:00:00")
            wait_until(lambda: seconds(listener)[-1] >= Y2035_S, "a stamp of 2035")
            wait_until(lambda: "health OK" in last_health(reader), "health to be OK again")
            assert end(reader) == 0
    finally:
        client.destroy()
    summary = summary_of(reader.out.lines)
    assert summary["not_sent"] > 0
    assert summary["received"] == summary["published"] + summary["rejected"] + summary["ignored"]
    # Nothing in between: neither a wrong stamp nor one that is made up.
    assert all(Y2030_S <= stamp < Y2030_S + 1000 or stamp >= Y2035_S for stamp in seconds(listener))


@needs_faketime
@pytest.mark.timeout(150)
def test_it_is_stopped_and_driven_at_a_date_at_which_dds_sends_nothing(
    tmp_path: Path, device: PtyDevice, context: Any
) -> None:
    date = FakeDate(tmp_path, "2030-01-01 00:00:00")
    client = Client(context, "lifecycle_manager")
    try:
        with imu_at(date, device) as reader:
            reader.waits_for("opened")
            client.await_services()
            wait_until(lambda: client.state() == "active", "the reader to be active", 40.0)
            date.set("2040-01-01 00:00:00")
            wait_until(lambda: "2040-01-01" in last_health(reader), "the health to name the date")
            assert client.change(label="deactivate")
            assert client.state() == "inactive"
            assert client.change(label="activate")
            assert end(reader) == 0
    finally:
        client.destroy()
    assert "a transition listener raised" not in reader.err


@pytest.mark.parametrize(
    ("now_ns", "refuses"),
    [
        (0, False),
        (5, False),
        (NOW_NS, False),
        (2**31 * S - 1, False),
        (2**31 * S, True),
        (Y2040_NS, True),
        (2**32 * S - 1, True),
        (2**32 * S, False),
        (Y2110_NS, False),
        (-1, True),
        (Y1969_NS, True),
        # Where the seconds would be positive again in 32 bits.
        (-(2**31) * S - 1, True),
    ],
)
def test_fast_dds_refuses_where_32_bits_with_a_sign_are_negative(
    now_ns: int, refuses: bool
) -> None:
    assert bool(date_refusal(now_ns, FASTDDS)) is refuses
    assert date_refusal(now_ns, "rmw_cyclonedds_cpp") == ""


def test_what_rclpy_says_at_a_date_that_is_none_is_said_with_the_date(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def refuse(*args: Any, **options: Any) -> None:
        raise AssertionError("The 'sec' field must be an integer")

    monkeypatch.setattr(starting, "SystemClock", lambda: ManualClock(Y2110_NS))
    monkeypatch.setattr(starting, "SharedNode", refuse)
    with pytest.raises(BackendError, match=r"is 2110-01-01 .* \(The 'sec' field must be"):
        Ros2Backend(BackendOptions("n"))


class Fake:
    """The rclpy publisher of a topic, which refuses."""

    topic_name = "/imu/data"
    qos_profile = QoSProfile(depth=10)

    def publish(self, message: object) -> None:
        raise RCLError("Failed to publish: cannot publish data")


@contextmanager
def refusing(
    monkeypatch: pytest.MonkeyPatch, now_ns: int, *, is_valid: bool = True
) -> Iterator[RosPublisher]:
    monkeypatch.setattr(refusals, "SystemClock", lambda: ManualClock(now_ns))
    context = SimpleNamespace(ok=lambda: is_valid)
    logger = make_logger("refusing", None, ManualClock())
    yield RosPublisher(Fake(), courier_of(Imu, Conversions()), Refusals(context, logger))


def both_ways(publisher: RosPublisher) -> list[Callable[[], object]]:
    """Publishing a message, and sending a sample."""
    send = publisher.prepared_sender(Imu(), VARYING)
    turned, still = (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
    return [lambda: publisher.publish(Imu()), lambda: send(7, turned, still, still)]


def test_a_message_that_dds_refuses_for_the_date_is_lost_and_said_at_a_limited_rate(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    with refusing(monkeypatch, Y2040_NS) as publisher:
        for way in both_ways(publisher) * 50:
            assert way() is False
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    assert "/imu/data" in record.message
    assert "2040-01-01" in record.message


def test_at_any_other_date_a_refusal_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    with refusing(monkeypatch, NOW_NS) as publisher:
        for way in both_ways(publisher):
            with pytest.raises(RCLError, match="cannot publish data"):
                way()


def test_a_parameter_is_declared_although_dds_does_not_take_the_event(
    backend: Ros2Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(event: object) -> None:
        raise RCLError("Failed to publish: cannot publish data")

    monkeypatch.setattr(backend.node._parameter_event_publisher, "publish", refuse)
    spec = ParameterSpec("rate", 1.0)
    with pytest.raises(ParameterError, match="cannot publish data"):
        backend.declare_parameter(ParameterSpec("at_a_good_date", 1.0))
    monkeypatch.setattr(refusals, "SystemClock", lambda: ManualClock(Y2040_NS))
    assert backend.declare_parameter(spec).value == 1.0
    # An empty list is taken for one of bytes, and is set once more.
    names = ParameterSpec("names", [], kind=ParameterKind.STRING_ARRAY)
    assert backend.declare_parameter(names).value == []
    assert backend.get_parameter("rate").value == 1.0


def test_a_topic_that_dds_does_not_let_be_created_is_an_error_that_names_the_date(
    backend: Ros2Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*arguments: object, **options: object) -> None:
        raise RCLError("Failed to create publisher: cannot publish data")

    monkeypatch.setattr(backend.node, "create_publisher", refuse)
    monkeypatch.setattr(refusals, "SystemClock", lambda: ManualClock(Y2040_NS))
    with pytest.raises(BackendError, match=r"^topic 'h': the date of .* 2040-01-01 .* \(Failed to"):
        backend.create_publisher(Header, "h", 10)


def test_a_timer_that_publishes_outlives_the_context_that_the_program_ends(
    backend: Ros2Backend,
) -> None:
    publisher = backend.create_publisher(Header, "h", 10)
    assert publisher.publish(Header()) is True
    backend.node.context.shutdown()
    assert publisher.publish(Header()) is False


def test_what_is_logged_at_such_a_date_is_on_rosout_with_a_stamp_of_zero(
    backend: Ros2Backend, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[Any] = []
    handler: Any = backend.log_handler
    monkeypatch.setattr(handler, "publisher", SimpleNamespace(publish=heard.append))
    for date_ns in (Y2040_NS, Y1969_NS, NOW_NS):
        record = logging.LogRecord("n", logging.INFO, "f.py", 1, "text", None, None)
        record.created = date_ns / S
        handler.handle(record)
    assert [message.stamp.sec for message in heard] == [0, 0, NOW_NS // S]
    assert {message.msg for message in heard} == {"text"}


def test_a_transition_before_1970_is_published_as_at_its_beginning(
    context: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clock.RosClock, "now_ns", lambda self: Y1969_NS)
    served = Served(context, SingleThreadedExecutor(context=context), LifecycleNode)
    client = Client(context)
    try:
        client.connect(served)
        served.managed.trigger_configure()
        client.await_events(1)
        assert [event.timestamp for event in client.events] == [0] * len(client.events)
    finally:
        client.destroy()
        served.destroy()


@pytest.mark.parametrize("date_ns", [Y1969_NS, Y2040_NS, Y2110_NS])
def test_the_clock_of_a_node_gives_what_can_be_sent(
    backend: Ros2Backend, monkeypatch: pytest.MonkeyPatch, date_ns: int
) -> None:
    monkeypatch.setattr(clock, "time", SimpleNamespace(time_ns=lambda: date_ns))
    assert backend.clock.now_ns() == date_ns
    assert backend.clock.now().nanoseconds == 0
    assert backend.create_publisher(Header, "h", 10).publish(Header(backend.clock.now())) is True
