"""The view as lines: pages, cursor, keys, and what is drawn anew."""

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase_view.drawing.glyphs import ASCII, UNICODE, Glyphs
from rosbase_view.drawing.lines import Line, cells, fitted, plain
from rosbase_view.known import Known
from rosbase_view.pages.page import Edit
from rosbase_view.reports import Counted, Heard, Logged, Report, Said, Survey
from rosbase_view.source import ChangeState, Gaze, SetParameter
from rosbase_view.view import PaneSize, View
from support.viewing import (
    ARM,
    IMU_SCHEMA,
    IMU_TOPIC,
    PID,
    imu_heard,
    made_process,
    made_program,
    made_topic,
    reports,
    survey,
)

NOW = 1_000_000_000_000
TOPICS, NODES, PARAMETERS, LOG, LOOP, PROGRAMS = range(6)
SMALL, LARGE = PaneSize(80, 10, NOW), PaneSize(96, 48, NOW)


def view_of(found: list[Report], glyphs: Glyphs = UNICODE, page: int = TOPICS) -> View:
    view = View(Known(), glyphs)
    view.known.take(found, NOW)
    view.turn_to(page)
    return view


def shown(lines: list[Line]) -> list[str]:
    return [plain(line).rstrip() for line in lines]


def record(text: str, stamp_ns: int = 0) -> Logged:
    made: list[object] = [
        {"pid": PID, "stamp_ns": stamp_ns, "level": 20, "name": "robot", "text": text}
    ]
    return Logged(made)  # type: ignore[arg-type]  # a record as JSON has it


@given(
    st.integers(0, 5),
    st.integers(1, 200),
    st.integers(1, 60),
    st.booleans(),
    st.sampled_from([UNICODE, ASCII]),
)
def test_every_page_fits_every_terminal(
    page: int, width: int, height: int, is_beside: bool, glyphs: Glyphs
) -> None:
    view = view_of(reports(), glyphs, page)
    size = PaneSize(width, height, NOW)
    for lines in (view.draw_list(size), view.draw_detail(size, is_beside=is_beside)):
        assert all(cells(plain(fitted(line, width))) == width for line in lines)
        assert all("\n" not in plain(line) for line in lines)


@pytest.mark.parametrize("page", range(6))
def test_every_page_is_drawn_without_unicode_if_the_terminal_has_none(page: int) -> None:
    view = view_of(reports(), ASCII, page)
    lines = [*view.draw_list(LARGE), *view.draw_detail(LARGE, is_beside=True)]
    assert "".join(shown([*lines, *view.draw_heading(80), *view.draw_status(80, NOW)])).isascii()


@pytest.mark.parametrize("page", range(6))
def test_every_page_says_when_nothing_runs(page: int) -> None:
    view = View(Known(), UNICODE)
    view.turn_to(page)
    assert shown(view.draw_list(SMALL))[1] == "  looking for programs"
    view.known.take([Survey((), {}, (), ())], NOW)
    assert shown(view.draw_list(SMALL))[1] == "  no program runs"
    assert view.chosen is None
    view.move(3)
    view.press("enter")
    view.draw_detail(SMALL, is_beside=False)


def test_topics_have_rate_age_and_type() -> None:
    head, first, *_ = shown(view_of(reports()).draw_list(SMALL))
    assert head.split() == ["TOPIC", "RATE", "AGE", "LAST", "8", "S", "TYPE"]
    assert first.split() == [
        "▶",
        "/imu/data",
        "200.0",
        "Hz",
        "now",
        "▇" * 16,
        "sensor_msgs/msg/Imu",
    ]


def test_topics_of_one_name_are_told_apart_by_their_programs() -> None:
    other = PID + 1
    found = attrs.evolve(
        survey(1),
        processes=[
            made_process(PID, made_program("/left")),
            made_process(other, made_program("/right")),
        ],
        topics={
            ("/imu/data", PID): made_topic("/imu/data"),
            ("/imu/data", other): made_topic("/imu/data"),
            ("/text", PID): made_topic("/text"),
        },
    )
    view = view_of([found])
    _, *rows = shown(view.draw_list(SMALL))
    assert ["left:" in row for row in rows] == [True, False, False]
    assert ["right:" in row for row in rows] == [False, True, False]
    assert shown(view.draw_detail(SMALL, is_beside=False))[1] == "/imu/data of left"


def test_a_program_that_does_not_answer_is_named_until_it_does() -> None:
    trouble = "no answer from quadruped [4711]"
    view = view_of(
        [attrs.evolve(survey(), silent=frozenset({PID}), trouble=trouble)], page=PROGRAMS
    )
    assert "does not answer" in shown(view.draw_list(SMALL))[1]
    much_later = NOW + 3_600_000_000_000
    assert plain(view.draw_status(80, much_later)[0]) == trouble
    view.known.take([survey()], much_later)
    assert "does not answer" not in shown(view.draw_list(SMALL))[1]
    assert "q quit" in " ".join(plain(view.draw_status(80, much_later)[0]).split())


def test_the_page_that_is_shown_is_marked_without_colour() -> None:
    view = view_of(reports(), page=LOG)
    assert plain(view.draw_heading(100)[0]).startswith(
        " 1 topics  2 nodes  3 parameters [4 log] 5 loop  6 programs "
    )
    assert plain(view.draw_heading(80)[0]).rstrip().endswith("1 program")


def test_only_rows_that_have_changed_are_made_anew() -> None:
    view = view_of(reports(50))
    before = view.draw_list(LARGE)
    # The rate and the age stay the same until the bar of the sparkline is complete.
    later = attrs.evolve(LARGE, now_ns=NOW + 100_000_000)
    view.known.take([Counted(IMU_TOPIC, 20, 0.1)], later.now_ns)
    assert all(a is b for a, b in zip(before[1:], view.draw_list(later)[1:], strict=True))
    view.known.take([Counted(IMU_TOPIC, 80, 0.4)], later.now_ns)
    after = view.draw_list(later)
    assert [y for y, line in enumerate(after) if y and line is not before[y]] == [1]


def test_a_message_is_drawn_once() -> None:
    view = view_of(reports())
    size = PaneSize(60, 40, NOW)
    before = view.draw_detail(size, is_beside=False)
    view.known.take([Counted(IMU_TOPIC, 20, 0.1)], NOW)
    after = view.draw_detail(size, is_beside=False)
    # The rule, the name and the ends are made each time.
    assert all(line is before[y] for y, line in enumerate(after) if y > 2)
    view.known.take([imu_heard(31.0)], NOW)
    assert view.draw_detail(size, is_beside=False)[3] is not before[3]


def test_an_imu_is_drawn_above_its_tree() -> None:
    lines = shown(view_of(reports()).draw_detail(PaneSize(60, 40, NOW), is_beside=True))
    assert lines[0] == "│ /imu/data"
    assert lines[1] == "│ 1 publisher, 0 subscriptions"
    assert "│ roll    0.0  pitch    0.0  yaw   30.0" in lines
    assert any(line.startswith("│ z    9.807") for line in lines)
    assert any("frame_id imu_link" in line for line in lines)


def test_an_imu_without_an_orientation_is_not_drawn_as_level() -> None:
    found: list[Report] = [survey(), imu_heard(orientation_covariance=(-1.0, *[0.0] * 8))]
    lines = shown(view_of(found).draw_detail(PaneSize(60, 40, NOW), is_beside=False))
    assert "no orientation" in lines
    assert not any("roll" in line for line in lines)


def test_the_message_of_another_topic_is_not_shown() -> None:
    view = view_of(reports())
    view.move(1)
    assert view.gaze == Gaze(topics=frozenset({("/joint_00/state", PID)}))
    assert "no message yet" in shown(view.draw_detail(SMALL, is_beside=False))


def test_details_scroll_and_fold() -> None:
    # Of another type, so that no picture is above it.
    other = Heard(IMU_TOPIC, "x/msg/X", IMU_SCHEMA, 0, imu_heard().data)
    view = view_of([survey(), other])
    size = PaneSize(60, 30, NOW)
    assert any("frame_id" in line for line in shown(view.draw_detail(size, is_beside=False)))
    view.scroll_detail(5)
    assert not any("frame_id" in line for line in shown(view.draw_detail(size, is_beside=False)))
    view.scroll_detail(-9)
    view.press("enter")
    folded = shown(view.draw_detail(size, is_beside=False))
    assert "▸ header" in folded
    assert not any("frame_id" in line for line in folded)


def test_the_view_begins_with_an_imu() -> None:
    found = survey()
    others = {
        ("/a/transition_event", PID): made_topic("/a", "lifecycle_msgs/msg/TransitionEvent"),
        ("/b", PID): made_topic("/b", "std_msgs/msg/Float64"),
    }
    view = view_of([attrs.evolve(found, topics=others)])
    assert view.chosen == ("/b", PID)
    # One that comes later does not take the eyes away.
    view.known.take([attrs.evolve(found, topics={**others, **found.topics})], NOW)
    assert view.chosen == ("/b", PID)
    assert view_of([attrs.evolve(found, topics={**others, **found.topics})]).chosen == IMU_TOPIC


def test_the_cursor_stays_with_its_topic_when_others_come() -> None:
    view = view_of([survey(3)])
    view.move(1)
    assert view.chosen == ("/joint_00/state", PID)
    more = {("/a", PID): made_topic("/a"), **survey(3).topics}
    view.known.take([attrs.evolve(survey(3), topics=more)], NOW)
    assert view.chosen == ("/joint_00/state", PID)
    view.known.take([attrs.evolve(survey(3), topics={("/a", PID): made_topic("/a")})], NOW)
    assert view.chosen == ("/a", PID)


@given(st.lists(st.integers(-60, 60), max_size=20), st.integers(1, 60))
def test_the_chosen_row_is_always_shown(moves: list[int], height: int) -> None:
    view = view_of([survey(50)])
    size = PaneSize(80, height + 1, NOW)
    for rows in moves:
        view.move(rows)
        marked = [line for line in shown(view.draw_list(size)) if line.startswith("▶")]
        assert len(marked) == 1


def test_a_click_chooses_the_row_under_it() -> None:
    view = view_of([survey(50)])
    view.move(49)
    drawn = shown(view.draw_list(SMALL))
    view.choose_at(3)
    assert isinstance(view.chosen, tuple)
    assert view.chosen[0] in drawn[3]
    view.choose_at(0)
    view.choose_at(500)
    assert view.chosen[0] in drawn[3]


@pytest.mark.parametrize(
    ("key", "transition"), [("a", "activate"), ("u", "cleanup"), ("s", "shutdown")]
)
def test_keys_run_the_transitions_that_the_node_offers(key: str, transition: str) -> None:
    view = view_of(reports(), page=NODES)
    assert view.chosen == ARM
    assert view.press(key) == ChangeState(ARM, transition)


@pytest.mark.parametrize("key", ["c", "d", "x"])
def test_a_transition_that_is_not_offered_has_no_key(key: str) -> None:
    assert view_of(reports(), page=NODES).press(key) is None


def test_a_key_is_of_the_node_that_is_chosen() -> None:
    view = view_of(reports(), page=NODES)
    # What is known is still that of the other node.
    view.move(1)
    assert view.press("a") is None


def edit_of(view: View) -> Edit:
    done = view.press("enter")
    assert done is not None
    assert not isinstance(done, (SetParameter, ChangeState))
    return done


def test_a_parameter_is_edited_as_text() -> None:
    view = view_of(reports(), page=NODES)
    assert view.press("enter") is None
    assert view.number == PARAMETERS
    assert shown(view.draw_list(SMALL))[1].split() == ["▶", "speed", "1.5", "double"]
    edit = edit_of(view)
    assert (edit.title, edit.text) == ("speed (double)", "1.5")
    assert edit.change("2") == SetParameter(ARM, "speed", "2")


def test_a_fixed_parameter_is_not_edited() -> None:
    view = view_of(reports(), page=PARAMETERS)
    view.move(1)
    assert "string, fixed" in shown(view.draw_list(SMALL))[2]
    assert view.press("enter") is None


def test_the_log_stays_at_its_end_until_the_cursor_is_moved_away() -> None:
    view = view_of([survey()], page=LOG)
    for number in range(30):
        view.known.take([record(f"line {number}")], NOW)
    assert shown(view.draw_list(SMALL))[-1].endswith("line 29")
    view.move(-3)
    view.known.take([record("line 30")], NOW)
    assert shown(view.draw_detail(SMALL, is_beside=False))[2] == "line 26"
    view.move(100)
    view.known.take([record("line 31")], NOW)
    assert shown(view.draw_list(SMALL))[-1].endswith("line 31")


def test_the_log_forgets_its_oldest_records() -> None:
    view = view_of([survey()], page=LOG)
    view.move(-1)
    for number in range(1_500):
        view.known.take([record(f"line {number}")], NOW)
    assert len(view.known.log) == 1_000
    view.move(-10_000)
    assert shown(view.draw_list(SMALL))[1].endswith("line 500")


def test_log_levels_are_words() -> None:
    view = view_of(reports(), page=LOG)
    assert shown(view.draw_list(SMALL))[1].split()[2:4] == ["WARN", "quadruped"]


def test_loop_times_have_percentiles_and_a_histogram() -> None:
    view = view_of(reports(), page=LOOP)
    row = shown(view.draw_list(LARGE))[1]
    assert "200.0 Hz" in row
    assert "5.120 ms" in row
    lines = shown(view.draw_detail(PaneSize(60, 4, NOW), is_beside=True))
    assert lines[0] == "│ periods of quadruped"
    # Four buckets have joined into the two that there is room for.
    assert [line.split()[5] for line in lines[1:3]] == ["3020", "1980"]


def test_programs_have_their_state_and_share_of_the_processor() -> None:
    view = view_of([Survey([made_process(cpu_ns=0)], {}, (), ())], page=PROGRAMS)
    later = Survey([made_process(cpu_ns=250_000_000)], {}, (), ())
    view.known.take([later], NOW + 1_000_000_000)
    row = shown(view.draw_list(LARGE))[1]
    assert "running: walk" in row
    assert "25.0 %" in row


def test_a_program_that_waits_says_for_what() -> None:
    waiting = made_program(phase="handshake", waiting_for=["imu"])
    view = view_of([Survey([made_process(PID, waiting)], {}, (), ())], page=PROGRAMS)
    assert "waiting for imu" in shown(view.draw_list(LARGE))[1]


def test_what_was_said_makes_way_for_the_keys_after_ten_seconds() -> None:
    view = view_of([Said("speed is set")])
    assert shown(view.draw_status(80, NOW)) == ["speed is set"]
    assert "quit" in shown(view.draw_status(80, NOW + 11_000_000_000))[0]


def test_names_of_other_programs_cannot_write_to_the_terminal() -> None:
    name = "/a\x1b[2J\nb"
    topics = {(name, PID): made_topic(name, "x\x1b]0;y\x07/msg/Z")}
    node = attrs.evolve(survey(), topics=topics)
    said = Said("\x1b[31mred")
    for page in range(6):
        view = view_of([node, record("\x1b[2J\nx"), said], page=page)
        lines = [
            *view.draw_list(LARGE),
            *view.draw_detail(LARGE, is_beside=False),
            *view.draw_status(80, NOW),
        ]
        assert all(plain(line).isprintable() for line in lines)


def test_the_pages_go_round() -> None:
    view = view_of(reports())
    seen = []
    for _ in range(6):
        view.turn_to(view.number + 1)
        seen.append(view.number)
    assert seen == [1, 2, 3, 4, 5, 0]


def test_a_message_that_cannot_be_read_is_one_line() -> None:
    broken = attrs.evolve(imu_heard(), data=b"\0\1\0\0 too short")
    view = view_of([survey(), broken])
    lines = shown(view.draw_detail(LARGE, is_beside=False))
    assert lines[3].startswith("cannot be read: ")


def test_messages_that_nobody_looks_at_are_forgotten() -> None:
    known = view_of(reports()).known
    known.forget_unseen(Gaze(topics=frozenset({IMU_TOPIC})))
    assert list(known.heard) == [IMU_TOPIC]
    known.forget_unseen(Gaze(nodes=frozenset({ARM})))
    assert not known.heard


def test_a_record_of_a_recording_is_shown_without_a_pid() -> None:
    found: list[object] = [
        {"pid": 0, "stamp_ns": 0, "level": 20, "name": "robot", "text": "it walks"}
    ]
    view = view_of([survey(), Logged(found)], page=LOG)  # type: ignore[arg-type]  # as above
    assert shown(view.draw_detail(SMALL, is_beside=False))[1] == "INFO of robot"
