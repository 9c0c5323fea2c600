"""The page without a browser: what it shows, what it asks for, what becomes of a press."""

from collections.abc import Iterable, Sequence

import pytest
from attrs import evolve

from rosbase.control.shapes import Topic
from rosbase_view.reports import (
    Counted,
    Heard,
    NodeReport,
    NodeRow,
    Position,
    Report,
    Said,
    Survey,
    TopicKey,
)
from rosbase_view.source import ChangeState
from rosbase_view.web.health import DIAGNOSTICS
from rosbase_view.web.model import ChooseNode, ChooseTopic, Model, RunTransition
from rosbase_view.web.quantities import ACCELERATION, MAGNETIC_FIELD
from rosbase_view.web.status_html import status_html
from support.viewing import IMU_TOPIC, PID, SECOND, imu_heard, made_process, made_topic

BOARD = ("/quadruped", PID)
ARM = ("/arm", PID)
OTHER_IMU = ("/arm/imu", PID)


def surveyed(
    topics: Iterable[TopicKey] = (IMU_TOPIC,), nodes: Iterable[tuple[str, int]] = (BOARD,)
) -> Survey:
    """A program with these Imus and lifecycle nodes."""
    found: dict[TopicKey, Topic] = {key: made_topic(key[0]) for key in topics}
    rows = [NodeRow(key, "/quadruped", "inactive") for key in nodes]
    return Survey([made_process()], found, rows, [])


def model_of(*reports: Report) -> Model:
    model = Model()
    model.take(reports, 0)
    return model


def heard(topic: TopicKey = IMU_TOPIC, yaw_degrees: float = 90.0, stamp_s: float = 0.0) -> Heard:
    return evolve(imu_heard(yaw_degrees), topic=topic, stamp_ns=int(stamp_s * SECOND))


def test_without_a_program_the_page_says_so() -> None:
    picture = Model().picture(0)
    assert "no program runs" in status_html(picture)
    assert (picture.topics, picture.nodes, picture.offered) == ([], [], frozenset())
    assert "no program publishes an Imu" in status_html(model_of(surveyed(())).picture(0))


def test_the_board_turns_with_its_messages_and_the_curves_grow() -> None:
    model = model_of(surveyed(), Counted(IMU_TOPIC, 10, 0.1), heard())
    picture = model.picture(0)
    assert picture.rotation == pytest.approx((0.5**0.5, 0.0, 0.0, 0.5**0.5))
    assert picture.traces[ACCELERATION].columns()[1] == (0.3,)
    model.take([heard(yaw_degrees=0.0, stamp_s=0.1)], 0)
    assert model.picture(0).rotation == (1.0, 0.0, 0.0, 0.0)
    assert "yaw 0.0°" in status_html(model.picture(0))
    assert len(picture.traces[ACCELERATION].columns()[0]) == 2


def test_an_orientation_that_is_old_is_not_shown_as_that_of_now() -> None:
    model = model_of(surveyed(), Counted(IMU_TOPIC, 10, 0.1), heard())
    assert model.picture(2 * SECOND).rotation is not None
    picture = model.picture(3 * SECOND)
    assert picture.rotation is None
    assert "last message: 3.0 s" in status_html(picture)


def test_a_board_that_falls_silent_has_no_rate_and_says_for_how_long() -> None:
    counts = [Counted(IMU_TOPIC, 10, 0.1, 0.01 * number) for number in reversed(range(10))]
    model = model_of(surveyed(), *counts, heard())
    assert "yaw" in status_html(model.picture(0))
    text = status_html(model.picture(7 * SECOND))
    assert "silent for 7.0 s" in text
    assert " Hz" not in text
    assert "no orientation" not in text


def test_a_board_whose_program_does_not_answer_stays_and_says_so() -> None:
    trouble = "no answer from quadruped [4711]"
    model = model_of(surveyed(), Counted(IMU_TOPIC, 10, 0.1), heard())
    model.take([evolve(surveyed(), silent=frozenset({PID}), trouble=trouble)], SECOND)
    picture = model.picture(SECOND)
    assert picture.topic == "/imu/data"
    assert "its program does not answer; last message: 1.0 s" in status_html(picture)
    assert trouble in status_html(picture)
    model.take([surveyed()], 2 * SECOND)
    assert "answer" not in status_html(model.picture(2 * SECOND))


def test_a_recording_that_stands_still_shows_its_last_message() -> None:
    position = Position(SECOND, 0, 10 * SECOND, is_playing=False)
    model = model_of(surveyed(), Counted(IMU_TOPIC, 10, 0.1), heard(), position)
    picture = model.picture(60 * SECOND)
    assert picture.rotation is not None
    assert picture.position == position


def test_the_page_asks_for_the_chosen_board_alone() -> None:
    field, away = ("/imu/mag", PID), ("/arm/mag", PID)
    health, elsewhere = ("/diagnostics", PID), ("/diagnostics", 99)
    found = surveyed([IMU_TOPIC, OTHER_IMU], [BOARD, ARM])
    topics = {
        **found.topics,
        field: made_topic("/imu/mag", MAGNETIC_FIELD),
        away: made_topic("/arm/mag", MAGNETIC_FIELD, publishers=[12]),
        health: made_topic("/diagnostics", DIAGNOSTICS),
        elsewhere: made_topic("/diagnostics", DIAGNOSTICS),
    }
    model = model_of(evolve(found, topics=topics))
    model.press(ChooseTopic("/imu/data"), 0)
    assert model.gaze.topics == {IMU_TOPIC, field, health}
    assert model.gaze.nodes == {BOARD}


def test_another_board_has_curves_and_a_node_of_its_own() -> None:
    found = surveyed([IMU_TOPIC, OTHER_IMU], [BOARD, ARM])
    for end in found.topics[OTHER_IMU]["publishers"]:
        end["node"] = "/arm"
    model = model_of(found, heard(OTHER_IMU))
    assert (model.picture(0).topic, model.picture(0).node) == ("/arm/imu", "/arm")
    assert model.picture(0).traces
    model.press(ChooseTopic("/imu/data"), 0)
    picture = model.picture(0)
    assert (picture.topic, picture.node, picture.traces) == ("/imu/data", "/quadruped", {})
    # One that was on its way.
    model.take([heard(OTHER_IMU)], 0)
    assert not model.picture(0).traces


def test_a_node_that_the_user_has_chosen_stays_chosen() -> None:
    model = model_of(surveyed(nodes=[BOARD, ARM]))
    assert model.picture(0).node == "/quadruped"
    model.press(ChooseNode("/arm"), 0)
    model.take([surveyed(nodes=[BOARD, ARM])], 0)
    assert model.picture(0).node == "/arm"


def offering(*transitions: str) -> Sequence[Report]:
    return [surveyed(), NodeReport(BOARD, [], transitions)]


def test_only_transitions_that_the_node_offers_are_shown_and_run() -> None:
    model = model_of(*offering("activate", "cleanup", "shutdown"))
    assert model.picture(0).offered == {"activate", "cleanup", "shutdown"}
    assert model.press(RunTransition("activate"), 0) == ChangeState(BOARD, "activate")
    assert "activate of /quadruped ..." in status_html(model.picture(0))
    assert model.press(RunTransition("configure"), 0) is None
    assert "does not offer configure now" in status_html(model.picture(0))


def test_a_node_that_is_gone_has_no_buttons() -> None:
    model = model_of(*offering("activate"), surveyed(nodes=[]))
    picture = model.picture(0)
    assert (picture.offered, picture.lifecycle, picture.node) == (
        frozenset(),
        "",
        "/quadruped (gone)",
    )
    assert model.press(RunTransition("activate"), 0) is None


def test_a_program_that_goes_and_comes_back_is_shown_again() -> None:
    model = model_of(surveyed(), Counted(IMU_TOPIC, 10, 0.1), heard())
    model.take([Survey((), {}, (), ())], 0)
    picture = model.picture(0)
    assert (picture.topic, picture.is_there, picture.rotation) == ("/imu/data (gone)", False, None)
    assert "nobody publishes it now" in status_html(picture)
    again = ("/imu/data", PID + 1)
    model.take([surveyed([again], []), Counted(again, 10, 0.1), heard(again)], 0)
    picture = model.picture(0)
    assert (picture.topic, picture.is_there) == ("/imu/data", True)
    assert picture.rotation is not None


def test_a_message_that_cannot_be_read_is_said_and_harms_nothing() -> None:
    model = model_of(surveyed(), Counted(IMU_TOPIC, 10, 0.1), evolve(heard(), data=b"\x00"))
    picture = model.picture(0)
    assert picture.rotation is None
    assert picture.said is not None
    assert picture.said.text.startswith("cannot read /imu/data")


def test_text_from_outside_is_no_html() -> None:
    text = "<img src=x onerror=alert(1)>\x1b[2J\u202e"
    html = status_html(model_of(surveyed(), Said(text, is_error=True)).picture(0))
    assert "<img" not in html
    assert "&lt;img src=x onerror=alert(1)&gt;\\x1b[2J\\u202e" in html
