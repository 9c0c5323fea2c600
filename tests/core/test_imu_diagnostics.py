"""What the reader says of itself on /diagnostics."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosbase.cli.report import summary_lines
from rosbase.contracts.transport import TransportHealth
from rosbase.errors import DeviceNotFoundError
from rosbase.lifecycle import CallbackReturn
from rosbase.messages import DiagnosticArray, DiagnosticStatus
from rosbase.testing import ScriptedTransport
from support.reader_rig import Rig
from support.samples import GOOD_FRAME, ORIENTATION_FAULTS


class Diagnosed(Rig):
    """A reader, and what it says."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.heard: list[DiagnosticArray] = []
        self.backend.create_subscription(DiagnosticArray, "/diagnostics", self.heard.append, 100)

    def status(self) -> DiagnosticStatus:
        """What it says next."""
        self.heard.clear()
        self.pass_time(1.0)
        (message,) = self.heard
        (status,) = message.status
        return status

    def values(self) -> dict[str, str]:
        """The figures that it gives next."""
        return {pair.key: pair.value for pair in self.status().values}


@pytest.fixture
def rigs() -> Iterator[Callable[..., Diagnosed]]:
    made: list[Diagnosed] = []

    def make(**options: Any) -> Diagnosed:
        made.append(Diagnosed(**options))
        return made[-1]

    yield make
    for rig in made:
        rig.backend.close()


def test_it_speaks_once_a_second_in_every_state(rigs: Callable[..., Diagnosed]) -> None:
    rig = rigs()
    rig.pass_time(10.5)
    assert len(rig.heard) == 10
    rig.activate()
    rig.pass_time(10.0)
    assert len(rig.heard) == 20
    rig.reader.trigger_shutdown()
    rig.pass_time(10.0)
    assert len(rig.heard) == 30


def test_a_reader_that_waits_to_be_brought_up_is_no_fault(rigs: Callable[..., Diagnosed]) -> None:
    status = rigs().status()
    assert (status.level, status.message) == (DiagnosticStatus.OK, "unconfigured")
    assert status.name == "lifecycle_manager: IMU"


def test_a_device_that_cannot_be_opened_is_an_error_until_it_can(
    rigs: Callable[..., Diagnosed],
) -> None:
    rig = rigs(failure=DeviceNotFoundError("/dev/imu is not there"))
    assert rig.reader.trigger_configure() is CallbackReturn.FAILURE
    status = rig.status()
    assert status.level == DiagnosticStatus.ERROR
    assert status.message == "unconfigured: /dev/imu is not there"
    rig.registry.failure = None
    rig.activate()
    rig.send(GOOD_FRAME)
    assert rig.status().level == DiagnosticStatus.OK


def test_an_error_in_any_text_is_said_in_one_that_ros_can_send(
    rigs: Callable[..., Diagnosed],
) -> None:
    rig = rigs(failure=DeviceNotFoundError("/dev/\udcff\0imu is not there"))
    assert rig.reader.trigger_configure() is CallbackReturn.FAILURE
    assert rig.status().message == r"unconfigured: /dev/\udcff\x00imu is not there"
    rig.registry.failure = None
    rig.activate().transport.failure = DeviceNotFoundError("\udcff\0")
    assert rig.values()["last error"] == r"\udcff\x00"


def test_a_fault_while_active_is_an_error_until_it_is_brought_up_again(
    rigs: Callable[..., Diagnosed],
) -> None:
    rig = rigs().activate()
    rig.reader.raise_error(RuntimeError("on fire"))
    assert rig.status().message == "unconfigured: on fire"
    rig.activate()
    assert "on fire" not in rig.status().message


def test_silence_is_a_warning_then_an_error(rigs: Callable[..., Diagnosed]) -> None:
    rig = rigs(stale_timeout=2.0).activate()
    levels = [rig.status().level for _ in range(12)]
    assert levels[0] == DiagnosticStatus.OK
    assert levels == sorted(levels)
    assert set(levels) == {DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR}


def test_the_figures_are_those_of_the_counts(rigs: Callable[..., Diagnosed]) -> None:
    rig = rigs().activate()
    rig.values()
    for _ in range(30):
        rig.send(GOOD_FRAME)
    for _ in range(3):
        rig.send(b"{}")
    rig.send(ORIENTATION_FAULTS["P5 not unit"][0])
    values = rig.values()
    assert values["state"] == "active"
    assert values["transport"] == "scripted connected"
    assert values["rate (Hz)"] == "31.0"
    assert (values["published"], values["rejected"]) == ("31", "3")
    assert values["left out: bad_quaternion"] == "1"
    assert values["no_imu_data"] == "3"
    assert values["last data (s ago)"] == "1.0"
    assert rig.values()["rate (Hz)"] == "0.0"


def test_the_figures_of_stamps_are_those_of_the_transport(
    rigs: Callable[..., Diagnosed], monkeypatch: pytest.MonkeyPatch
) -> None:
    rig = rigs().activate()
    said = TransportHealth(
        interval_ns=10_000_000, jitter_ns=1_234_567, clock_steps=2, late_frames=900
    )
    monkeypatch.setattr(ScriptedTransport, "health", said)
    values = rig.values()
    assert values["usual interval (ms)"] == "10.000"
    assert values["arrival jitter (ms)"] == "1.235"
    assert (values["clock steps"], values["late frames"]) == ("2", "900")
    lines = list(summary_lines(rig.reader, 0, None))
    assert "late_frames 900" in lines
    assert "clock_steps 2" in lines
