"""Parameters of the reader that are set while it runs: counted at once, or refused."""

import logging
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rosbase.lifecycle import CallbackReturn, State
from rosbase.parameters import Parameter, SetParametersResult
from support.reader_rig import Rig
from support.samples import GOOD_FRAME


@pytest.fixture
def rigs() -> Iterator[Callable[..., Rig]]:
    made: list[Rig] = []

    def make(**options: Any) -> Rig:
        made.append(Rig(**options))
        return made[-1]

    yield make
    for rig in made:
        rig.backend.close()


def put(rig: Rig, **values: Any) -> str:
    """Set parameters, underscores for dots; give the reason of a refusal."""
    result = rig.backend.set_parameters(
        [Parameter(name.replace("__", "."), value) for name, value in values.items()]
    )
    for name, value in values.items():
        is_set = rig.backend.get_parameter(name.replace("__", ".")).value == value
        assert is_set or not result.successful
    assert result.successful or "\n" not in result.reason
    return "" if result.successful else result.reason


def test_while_active_the_frame_and_the_deviations_count_from_the_next_sample(
    rigs: Callable[..., Rig],
) -> None:
    rig = rigs().activate()
    ((_, before),) = rig.send(GOOD_FRAME)
    assert put(rig, frame_id="imu_left", angular_velocity_stddev=[0.5]) == ""
    ((topic, after),) = rig.send(GOOD_FRAME)
    assert topic == "data"
    assert (before.header.frame_id, after.header.frame_id) == ("imu_link", "imu_left")
    assert after.angular_velocity_covariance == (0.25, 0, 0, 0, 0.25, 0, 0, 0, 0.25)
    assert rig.reader.settings.frame_id == "imu_left"
    assert rig.reader.counts.published == 2


def test_while_inactive_the_mapping_and_the_checks_count_at_once(rigs: Callable[..., Rig]) -> None:
    rig = rigs()
    assert rig.reader.trigger_configure() is CallbackReturn.SUCCESS
    assert put(rig, mapping__required=[], frozen="off", linear_acceleration_full_scale=5.0) == ""
    assert rig.reader.settings.checks.frozen == "off"
    assert rig.reader.trigger_activate() is CallbackReturn.SUCCESS
    ((_, message),) = rig.send(GOOD_FRAME)
    # An acceleration of 9.8 m/s^2 is left out, now that it may be.
    assert message.linear_acceleration_covariance[0] == -1.0
    assert message.angular_velocity_covariance[0] == 0.0


@pytest.mark.parametrize(
    ("state", "name", "value", "said"),
    [
        (State.INACTIVE, "gain", 7.0, "set it while unconfigured"),
        (State.INACTIVE, "topic_namespace", "left", "set it while unconfigured"),
        (State.INACTIVE, "stale_timeout", 3.0, "set it while unconfigured"),
        (State.INACTIVE, "time_source", "device", "set it while unconfigured"),
        (State.INACTIVE, "comm_t", "serial", "set it while unconfigured"),
        (State.ACTIVE, "gain", 7.0, "set it while unconfigured"),
        (State.ACTIVE, "mapping.required", [], "set it while inactive or unconfigured"),
        (State.ACTIVE, "preset", "mpu6050", "set it while inactive or unconfigured"),
        (State.ACTIVE, "plausibility", "reject", "set it while inactive or unconfigured"),
        (State.ACTIVE, "magnetic_field_full_scale", 1.0, "set it while inactive or unconfig"),
        (State.FINALIZED, "frame_id", "x", "cannot be set any more: the node is finalized"),
        (State.UNCONFIGURED, "autostart", "activate", "parameter autostart is read-only"),
    ],
)
def test_what_would_not_count_is_refused_with_the_time_when_it_would(
    rigs: Callable[..., Rig], state: State, name: str, value: Any, said: str
) -> None:
    rig = rigs()
    bring(rig, state)
    reason = put(rig, **{name.replace(".", "__"): value})
    assert reason.startswith(f"parameter {name} ")
    assert said in reason


def bring(rig: Rig, state: State) -> None:
    if state in (State.INACTIVE, State.ACTIVE):
        rig.reader.trigger_configure()
    if state is State.ACTIVE:
        rig.reader.trigger_activate()
    if state is State.FINALIZED:
        rig.reader.trigger_shutdown()
    assert rig.reader.get_state() is state


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("frame_id", "/imu", "did you mean imu?"),
        ("frame_id", "", "is empty"),
        ("topic_namespace", "a//b", "parameter topic_namespace"),
        ("preset", "mpu6051", "mpu6051"),
        ("comm_t", "serail", "serail"),
        ("mapping.orientation.paths", ["$.x"], "'$.x' is not a path"),
        ("mapping.linear_acceleration.unit", "furlong", "furlong"),
        ("angular_velocity_stddev", [1.0, 2.0], "angular_velocity_stddev"),
        ("stale_timeout", 0.0, "stale_timeout"),
        ("checksum_separator", "", ""),
    ],
)
def test_a_wrong_value_is_refused_when_it_is_set_not_when_it_is_used(
    rigs: Callable[..., Rig], name: str, value: Any, said: str
) -> None:
    rig = rigs(checksum="xor")
    reason = put(rig, **{name.replace(".", "__"): value})
    assert reason
    assert said in reason
    assert rig.reader.trigger_configure() is CallbackReturn.SUCCESS


def test_what_the_transport_refuses_is_refused_when_it_is_set(rigs: Callable[..., Rig]) -> None:
    rig = rigs()

    def refuse() -> Any:
        raise ValueError("gain is odd")

    rig.registry.create = refuse
    assert "gain is odd" in put(rig, gain=7.0)


def test_the_value_that_it_has_already_can_be_set_in_every_state(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    assert put(rig, stale_timeout=1.0, topic_namespace="imu", frame_id="imu_link") == ""


def test_several_are_set_together_or_not_at_all(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    assert "set it while unconfigured" in put(rig, frame_id="left", stale_timeout=2.0)
    ((_, message),) = rig.send(GOOD_FRAME)
    assert message.header.frame_id == "imu_link"


def test_during_a_transition_nothing_can_be_set(rigs: Callable[..., Rig]) -> None:
    rig = rigs()
    reasons: list[str] = []
    rig.reader.add_transition_listener(lambda event: reasons.append(put(rig, frame_id="left")))
    rig.reader.trigger_configure()
    assert reasons
    assert all(reason.startswith("busy: ") for reason in reasons)


def test_a_parameter_of_the_program_is_no_affair_of_the_reader(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    rig.reader.declare_parameter("gains", [1.0, 2.0])
    assert put(rig, gains=[3.0]) == ""


def test_what_has_no_effect_is_said_once(
    rigs: Callable[..., Rig], caplog: pytest.LogCaptureFixture
) -> None:
    rig = rigs()
    rig.reader.trigger_configure()
    with caplog.at_level(logging.WARNING):
        put(rig, frozen="off", frozen_after=5.0)
        put(rig, plausibility="off")
    said = [record.getMessage() for record in caplog.records]
    assert said == ["frozen_after has no effect: frozen is off"]


def test_a_subclass_may_refuse_what_the_reader_would_take(rigs: Callable[..., Rig]) -> None:
    rig = rigs().activate()
    rig.reader.add_on_set_parameters_callback(
        lambda parameters: SetParametersResult(successful=False, reason="not here")
    )
    assert put(rig, frame_id="left") == "not here"
    ((_, message),) = rig.send(GOOD_FRAME)
    assert message.header.frame_id == "imu_link"
