"""How well an active reader is: by its samples, at any rate, without flapping. In virtual time."""

from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rosbase.contracts.transport import TransportHealth, TransportState
from rosbase.imu.counts import Counts
from rosbase.imu.health import Health, HealthLevel
from rosbase.imu.health_watch import HealthWatch, device_fault
from rosbase.imu.rejects import NO_SIGN_OF_LIFE, REASONS
from support.health_stream import LOOK_S, SAMPLE, Said, bytes_of, every, levels, watch

OK, WARN, ERROR = HealthLevel.OK, HealthLevel.WARN, HealthLevel.ERROR

rates = st.floats(0.5, 200.0)
offsets = st.floats(0.0, LOOK_S)
timeouts = st.floats(0.1, 10.0)
reasons = st.sampled_from(sorted(set(REASONS) - NO_SIGN_OF_LIFE - {"unended", "no_frame"}))


def kinds(said: list[Said]) -> list[str]:
    """What the messages say, each change once."""
    changes: list[str] = []
    for _, health in said:
        if not changes or changes[-1] != health.kind:
            changes.append(health.kind)
    return changes


def first(said: list[Said], level: HealthLevel) -> float:
    return next(at_s for at_s, health in said if health.level is level)


def settles(said: list[Said], *, is_late: bool) -> bool:
    """Whether it becomes a warning and stays one; silence before what comes late is an error."""
    changes = [level for level in levels(said) if level is not OK]
    return changes == [WARN] or (is_late and changes == [WARN, ERROR, WARN])


@given(rates, timeouts, offsets, reasons)
def test_whatever_rate_refused_frames_have_it_is_warn_in_time_and_stays_so(
    rate_hz: float, timeout_s: float, offset_s: float, reason: str
) -> None:
    end_s = timeout_s + 20.0
    said = watch(
        every(reason, rate_hz, 1 / rate_hz, end_s),
        until_s=end_s,
        stale_timeout_s=timeout_s,
        offset_s=offset_s,
    )
    assert first(said, WARN) <= timeout_s + 1.0
    assert settles(said, is_late=1 / rate_hz > 5 * timeout_s - LOOK_S)
    assert said[-1].health.message == f"nothing usable arrives: {reason}: {REASONS[reason]}"
    assert len(kinds(said)) <= 5


@given(rates, timeouts, offsets, reasons)
def test_after_good_samples_refused_frames_of_any_rate_are_a_warning_that_stays(
    rate_hz: float, timeout_s: float, offset_s: float, reason: str
) -> None:
    end_s = 3.0 + timeout_s + 20.0
    said = watch(
        every(SAMPLE, 100.0, 0.0, 3.0),
        every(reason, rate_hz, 3.0, end_s),
        until_s=end_s,
        stale_timeout_s=timeout_s,
        offset_s=offset_s,
    )
    assert 3.0 + timeout_s - 0.02 <= first(said, WARN) <= 3.0 + timeout_s + 1.0
    assert settles(said, is_late=1 / rate_hz > 5 * timeout_s - LOOK_S)
    assert said[-1].health.kind == f"nothing usable arrives: {reason}"


@example(rate_hz=1.0, count=1, timeout_s=0.125, offset_s=0.2)
@given(rates, st.integers(1, 500), timeouts, offsets)
def test_bytes_without_an_end_of_line_are_a_warning_at_any_rate(
    rate_hz: float, count: int, timeout_s: float, offset_s: float
) -> None:
    end_s = timeout_s + 20.0
    said = watch(
        bytes_of(count, rate_hz, 1 / rate_hz, end_s),
        until_s=end_s,
        stale_timeout_s=timeout_s,
        offset_s=offset_s,
    )
    assert first(said, WARN) <= timeout_s + 1.0
    assert settles(said, is_late=1 / rate_hz > 5 * timeout_s - LOOK_S)
    last = said[-1].health
    assert last.kind == "nothing usable arrives: unended"
    assert "bytes without an end of line" in last.message
    # The number goes up all the time, and it is one message.
    assert len({health for _, health in said}) > 3
    assert len(kinds(said)) <= 6


@given(rates, timeouts.filter(lambda s: s > 0.3), offsets, reasons)
def test_it_is_ok_within_a_second_of_the_first_sample(
    rate_hz: float, timeout_s: float, offset_s: float, reason: str
) -> None:
    begin_s = 7.3
    said = watch(
        every(reason, rate_hz, 0.0, begin_s),
        every(SAMPLE, 50.0, begin_s, begin_s + 5.0),
        until_s=begin_s + 4.9,
        stale_timeout_s=timeout_s,
        offset_s=offset_s,
    )
    later = [health for at_s, health in said if at_s >= begin_s + LOOK_S]
    assert {health.level for health in later} == {OK}
    assert {health.message for health in later} == {"samples arrive"}


@given(st.floats(1.2, 200.0), rates, offsets, reasons)
def test_as_long_as_samples_go_out_it_is_ok_whatever_else_arrives(
    sample_hz: float, rate_hz: float, offset_s: float, reason: str
) -> None:
    said = watch(
        every(SAMPLE, sample_hz, 0.1, 30.0),
        every(reason, rate_hz, 0.05, 30.0),
        every("other_topic", 50.0, 0.07, 30.0),
        until_s=29.0,
        offset_s=offset_s,
    )
    assert levels(said) == [OK]


@given(st.lists(reasons, min_size=2, max_size=5, unique=True), rates, offsets, st.randoms())
def test_reasons_that_take_turns_do_not_make_the_message_flap(
    several: list[str], rate_hz: float, offset_s: float, random: Any
) -> None:
    in_turn = watch(
        every(lambda number: several[number % len(several)], rate_hz, 0.0, 60.0),
        until_s=59.0,
        offset_s=offset_s,
    )
    assert len(kinds(in_turn)) <= 4
    by_chance = watch(
        every(lambda _: random.choice(several), rate_hz, 0.0, 60.0),
        until_s=59.0,
        offset_s=offset_s,
    )
    assert len(kinds(by_chance)) <= 10


def test_a_device_that_falls_silent_is_a_warning_and_then_an_error() -> None:
    said = watch(every(SAMPLE, 100.0, 0.0, 2.0), until_s=9.0)
    assert levels(said) == [OK, WARN, ERROR]
    assert 2.99 < first(said, WARN) <= 3.25
    assert 6.99 < first(said, ERROR) <= 7.25
    assert said[-1].health.message == "no data for 7.0 s"
    assert kinds(said) == ["samples arrive", "no data for # s"]


@pytest.mark.parametrize("rate_hz", [0.03, 0.1, 0.2, 0.4])
def test_what_sends_nonsense_more_seldom_than_the_timeout_is_not_silent_in_between(
    rate_hz: float,
) -> None:
    said = watch(
        every(SAMPLE, 100.0, 0.0, 2.0), every("not_data", rate_hz, 2.5, 300.0), until_s=299.0
    )
    later = [each for each in said if each.at_s > 2.5 + 1 / rate_hz + LOOK_S]
    assert kinds(later) == ["nothing usable arrives: not_data"]


def test_what_sent_nonsense_and_falls_silent_is_an_error_after_five_times_the_timeout() -> None:
    said = watch(every("not_data", 10.0, 0.0, 4.0), until_s=12.0)
    assert levels(said) == [OK, WARN, ERROR]
    assert 8.9 < first(said, ERROR) <= 9.25
    assert said[-1].health.message.startswith("no data for 8")


def test_the_commonest_reason_since_the_last_sample_counts_and_not_an_earlier_one() -> None:
    said = watch(
        every("not_data", 50.0, 0.0, 4.0),
        every(SAMPLE, 50.0, 4.0, 5.0),
        every("no_imu_data", 4.0, 5.0, 9.0),
        every("empty", 1.0, 5.5, 9.0),
        until_s=8.9,
    )
    assert said[-1].health.kind == "nothing usable arrives: no_imu_data"
    assert kinds(said)[-2:] == ["samples arrive", "nothing usable arrives: no_imu_data"]


def test_reasons_that_take_turns_of_about_the_same_length_do_not_alternate() -> None:
    turns = [
        ("not_data", 0.0, 5.0),
        ("bad_json", 5.0, 11.0),
        ("not_data", 11.0, 17.0),
        ("bad_json", 17.0, 23.0),
    ]
    said = watch(*(every(what, 10.0, begin_s, end_s) for what, begin_s, end_s in turns), until_s=23)
    assert kinds(said)[1:] == ["nothing usable arrives: not_data"]


def test_a_reason_that_has_clearly_become_the_commonest_takes_over_and_is_said_once() -> None:
    said = watch(
        every("not_data", 10.0, 0.0, 2.0), every("no_imu_data", 10.0, 2.0, 12.0), until_s=11.9
    )
    assert kinds(said)[-2:] == [
        "nothing usable arrives: not_data",
        "nothing usable arrives: no_imu_data",
    ]


def test_messages_of_another_device_and_kept_ones_do_not_hide_that_this_one_is_silent() -> None:
    said = watch(
        every("retained", 1.0, 0.0, 0.5), every("other_topic", 100.0, 0.0, 9.0), until_s=8.9
    )
    assert levels(said) == [OK, WARN, ERROR]
    assert kinds(said) == ["waiting for the first sample", "no data for # s"]


@pytest.mark.parametrize(
    ("chunk", "rate_hz", "shown"),
    [(25, 20.0, 1000), (1, 0.5, 1), (16, 700.0, 10_000)],
)
def test_the_figure_is_how_many_bytes_wait(chunk: int, rate_hz: float, shown: int) -> None:
    said = watch(bytes_of(chunk, rate_hz, 0.0, 12.0), until_s=11.9)
    message = said[-1].health.message
    number = int(message.removeprefix("nothing usable arrives: unended: ").split()[0])
    assert number >= shown
    assert number % chunk == 0


def test_the_end_of_a_line_that_takes_a_moment_to_arrive_is_awaited() -> None:
    # Every two seconds a line, of which looks see the first half only.
    def halves() -> list[Said]:
        stream = []
        for number in range(10):
            begin_s = 2.0 * number + 0.24
            stream += [*bytes_of(30, 1000.0, begin_s, begin_s + 0.001)]
            stream += [*every("no_imu_data", 1000.0, begin_s + 0.1, begin_s + 0.101)]
        return watch(stream, until_s=19.0)

    assert not [health for _, health in halves() if "unended" in health.kind]


def test_data_without_any_frame_is_said_to_be_so() -> None:
    blank_lines = every("", 2.0, 0.0, 9.0)
    said = watch(every(SAMPLE, 10.0, 0.0, 0.1), blank_lines, until_s=8.9)
    assert said[-1].health.kind == "nothing usable arrives: no_frame"
    assert levels(said) == [OK, WARN]


def test_binary_noise_with_an_end_of_line_now_and_then_does_not_flap() -> None:
    # At a wrong rate one byte in 256 is a line feed.
    noise = [*bytes_of(8, 4.0, 0.0, 60.0), *every("not_utf8", 0.125, 4.1, 60.0)]
    said = watch(sorted(noise), until_s=59.0)
    assert len(kinds(said)) <= 4
    assert levels(said) == [OK, WARN]


def test_a_sample_that_comes_while_it_is_looked_at_counts_from_then_on() -> None:
    counts = Counts()
    watching = HealthWatch(1.0, 0, counts.snapshot({}))
    transport = TransportHealth(TransportState.CONNECTED)
    for second in range(1, 6):
        now_ns = second * 1_000_000_000
        # Counted already, and not yet known when the transport was asked.
        counts.published += 1
        assert watching.look(now_ns, counts.snapshot({}), transport).level is OK
        transport = TransportHealth(TransportState.CONNECTED, last_data_ns=now_ns)
        assert watching.look(now_ns + 999_000_000, counts.snapshot({}), transport).level is OK


def test_a_device_that_is_away_or_was_so_a_moment_ago_is_one_error() -> None:
    said = watch(
        every(SAMPLE, 100.0, 0.0, 3.0), every(SAMPLE, 100.0, 6.0, 9.0), until_s=8.9, lost=(3.0, 5.9)
    )
    assert levels(said) == [OK, ERROR, OK]
    (message,) = {health.message for _, health in said if health.level is ERROR}
    assert message == "waiting for the device: /dev/imu is not there"


def test_a_device_that_comes_and_goes_says_the_same_throughout() -> None:
    away = TransportHealth(TransportState.RECONNECTING, last_error="lost after 3 s")
    back = TransportHealth(TransportState.CONNECTED, last_error="lost after 12 s")
    assert device_fault(away).says_the_same_as(device_fault(back))
    assert device_fault(away).message == "waiting for the device: lost after 3 s"
    assert device_fault(back).message == "lost after 12 s"
    nameless = TransportHealth(TransportState.RECONNECTING)
    assert device_fault(nameless).message == "waiting for the device"


def test_a_reader_thread_that_has_died_stays_an_error() -> None:
    # Its device is silent from then on, which must not make it a mere warning for a while.
    said = watch(every(SAMPLE, 100.0, 0.0, 2.0), until_s=30.0, lost=(2.0, 31.0))
    assert levels(said) == [OK, ERROR]


def test_a_finding_is_a_warning_whose_figures_may_change() -> None:
    said = watch(every(SAMPLE, 100.0, 0.0, 3.0), until_s=2.9, finding="at rest 9.7 instead of 9.81")
    assert levels(said) == [WARN]
    again = Health(WARN, "at rest -1.5e+03 instead of 9.81")
    assert again.says_the_same_as(said[-1].health)
    assert not again.says_the_same_as(Health(OK, again.message))


def watched(*damaged: int, reason: str = "not_utf8", published: bool = False) -> list[Health]:
    """What a look a second says of frames that are refused, and so many framing errors so far."""
    counts = Counts()
    watching = HealthWatch(1.0, 0, counts.snapshot({}))
    said = []
    for second, number in enumerate(damaged, start=1):
        counts.add(reason)
        counts.published += published
        now_ns = second * 1_000_000_000
        transport = TransportHealth(
            TransportState.CONNECTED,
            last_data_ns=now_ns,
            link_errors={"framing_error": number, "overrun": 5},
        )
        said.append(watching.look(now_ns, counts.snapshot({}), transport))
    return said


def test_framing_errors_are_the_true_sign_of_a_wrong_baud_rate() -> None:
    said = watched(0, 0, 214, 500)
    assert said[1].message == f"nothing usable arrives: not_utf8: {REASONS['not_utf8']}"
    assert said[3].message == (
        "nothing usable arrives: not_utf8, with framing errors: "
        "500 bytes as if sent at another baud rate"
    )
    assert not said[1].says_the_same_as(said[2]), "it is said"
    assert said[2].says_the_same_as(said[3]), "once"


def test_framing_errors_of_an_earlier_time_are_not_held_against_the_device() -> None:
    assert "framing" not in watched(214, 214, 214)[-1].message


def test_framing_errors_beside_samples_are_no_matter_of_health() -> None:
    assert {health.level for health in watched(0, 3, 9, published=True)} == {OK}
