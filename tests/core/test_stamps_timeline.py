"""Stamps of a stream rise, and say what is known of the arrival: by simple bounds."""

from itertools import pairwise
from typing import Any

from hypothesis import given, settings

from rosbase.stamps import LATE_NS, Rhythm, Timeline
from support.made_stream import MadeStream, Stamped
from support.strategies import MadeRead, made_reads

MS = 1_000_000
S = 1_000 * MS
# How far a stamp may be off because somebody else had the processor between two clocks.
MOST_HELD_NS = 20 * MS


def stamps_of(reads: list[Stamped]) -> list[int]:
    return [stamp for read in reads for stamp in read.stamps if stamp is not None]


@given(made_reads)
@settings(max_examples=200)
def test_stamps_strictly_rise_and_each_step_of_the_clock_is_one_break(made: list[MadeRead]) -> None:
    stream = MadeStream()
    last_ns: int | None = None
    # How the date was set since frames came last; nothing, before the first of them.
    steps: list[int] | None = None
    for read in made:
        stamped = stream.read(read)
        if steps is not None:
            steps += [read.step_ns] * (read.step_ns != 0)
        if not read.frames:
            continue
        step_ns = sum(steps or [])
        # Several that cancel each other are none.
        if abs(step_ns) > 100 * MS or not steps:
            assert (stamped.step_ns != 0) == (step_ns != 0)
        if stamped.step_ns:
            assert abs(stamped.step_ns - step_ns) <= MOST_HELD_NS
            last_ns = None
        steps = []
        for stamp in stamped.stamps:
            if stamp is not None:
                assert last_ns is None or stamp > last_ns
                last_ns = stamp


@given(made_reads)
@settings(max_examples=200)
def test_no_stamp_is_after_its_read_or_before_the_look_before_it(made: list[MadeRead]) -> None:
    stream = MadeStream()
    for read in made:
        stamped = stream.read(read)
        for number, stamp in enumerate(stamped.stamps):
            if stamp is None:
                continue
            assert stamp <= stamped.date_ns
            if number < stamped.carried:
                # No later than it is known to have begun.
                assert stamp <= stamped.begun_ns
                assert stamp >= stamped.begun_ns - MOST_HELD_NS
            else:
                assert stamp > stamped.looked_ns - MOST_HELD_NS


@given(made_reads)
@settings(max_examples=200)
def test_frames_of_a_read_are_even_and_no_farther_apart_than_usual(made: list[MadeRead]) -> None:
    stream = MadeStream()
    for read in made:
        stamped = stream.read(read)
        here = [stamp for stamp in stamped.stamps[stamped.carried :] if stamp is not None]
        gaps = [after - before for before, after in pairwise(here)]
        assert len(set(gaps)) <= 1
        window_ns = stamped.date_ns - stamped.looked_ns + MOST_HELD_NS
        for gap in gaps:
            assert gap * len(here) <= window_ns
            assert gap <= (stamped.usual_ns or 10 * MS)


@given(made_reads)
@settings(max_examples=200)
def test_only_what_has_waited_for_long_is_dropped_and_then_all_that_began_in_the_wait(
    made: list[MadeRead],
) -> None:
    stream = MadeStream()
    was_late = False
    dropped: set[int] = set()
    for read in made:
        stamped = stream.read(read)
        carried, here = stamped.stamps[: stamped.carried], stamped.stamps[stamped.carried :]
        # A frame that began before the wait keeps its date; one that began in it has none.
        assert all((stamp is None) == (stamped.begun_at_ns in dropped) for stamp in carried)
        assert len({stamp is None for stamp in here}) <= 1
        is_dropped = None in here
        if is_dropped:
            dropped.add(stamped.at_ns)
        has_waited = stamped.date_ns - stamped.looked_ns > LATE_NS - MOST_HELD_NS
        assert not is_dropped or has_waited or was_late
        # Behind a wait, what nobody can date comes in a hurry; what comes alone is of now.
        assert not (is_dropped and len(here) == 1 and not has_waited)
        was_late = is_dropped or (was_late and not here)


def steady(stream: MadeStream, count: int, interval_ns: int, frames: int = 1) -> list[Stamped]:
    """So many reads at one distance."""
    return [stream.read(found(interval_ns, frames)) for _ in range(count)]


def found(pause_ns: int, frames: int = 1, **more: Any) -> MadeRead:
    """A read of a reader that did nothing but wait for it."""
    made = MadeRead(pause_ns - 1_000, looks=False, frames=frames, begins=False, step_ns=0,
                    held_ns=(0, 0))  # fmt: skip
    return made._replace(**more)


def gaps_of(reads: list[Stamped]) -> list[float]:
    """The distances of neighbours, in milliseconds."""
    return [(after - before) / MS for before, after in pairwise(stamps_of(reads))]


def test_a_frame_that_comes_alone_is_stamped_when_it_is_read() -> None:
    stream = MadeStream()
    for pause_ns in (MS, 10 * MS, 900 * MS, 10 * MS):
        read = stream.read(found(pause_ns))
        assert read.stamps == [read.date_ns]


def test_a_short_stall_at_100_hz_leaves_the_stamps_10_ms_apart() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    stalled = [*steady(stream, 1, 10 * MS), stream.read(found(207 * MS, 20))]
    after = stream.read(found(3 * MS))
    assert all(9.8 < gap < 10.2 for gap in gaps_of(stalled))
    # It is 10 ms after the last one that had waited, and not 3 ms after the read of that.
    assert all(9.8 < gap < 10.2 for gap in gaps_of([stalled[-1], after])[-1:])


def test_two_lines_in_one_write_twenty_times_a_second_are_half_an_interval_apart() -> None:
    stream = MadeStream()
    steady(stream, 10, 50 * MS, frames=2)
    assert all(24.9 < gap < 25.1 for gap in gaps_of(steady(stream, 50, 50 * MS, frames=2)))


def test_an_adapter_that_hands_over_every_16_ms_leaves_no_two_stamps_closer_than_half() -> None:
    stream = MadeStream()
    counts = [(16 * n + 16) // 10 - 16 * n // 10 for n in range(200)]
    reads = [stream.read(found(16 * MS, count)) for count in counts]
    gaps = gaps_of(reads[50:])
    assert min(gaps) >= 7.9
    assert max(gaps) <= 16.1
    assert 9.5 < stream.rhythm.interval_ns / MS < 10.5
    assert 2.0 < stream.rhythm.jitter_ns / MS < 8.0


def test_frames_that_begin_in_one_chunk_and_end_in_the_next_are_evenly_stamped_too() -> None:
    # 100 Hz on a line that takes 5 ms for a frame, behind an adapter with 16 ms of latency.
    stream = MadeStream()
    reads = []
    for number in range(200):
        until_ms, before_ms = 16 * number + 16, 16 * number
        ends = (until_ms - 5) // 10 - (before_ms - 5) // 10
        reads.append(stream.read(found(16 * MS, ends, begins=until_ms % 10 < 5)))
    gaps = gaps_of(reads[50:])
    assert min(gaps) >= 7.9
    assert max(gaps) <= 16.1


def test_several_messages_in_one_segment_are_as_far_apart_as_they_were_sent() -> None:
    stream = MadeStream()
    steady(stream, 10, 200 * MS, frames=2)
    assert all(99 < gap < 101 for gap in gaps_of(steady(stream, 20, 200 * MS, frames=2)))


def test_a_pause_before_a_burst_says_nothing_of_the_burst() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    burst = stream.read(found(900 * MS, 5))
    assert burst.stamps[-1] == burst.date_ns
    assert all(9.0 < gap < 11.0 for gap in gaps_of([burst]))


def test_on_a_line_whose_speed_is_known_a_few_frames_are_as_close_as_they_were_sent() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS, frames=2)
    for frames, gap_ns in ((2, MS), (4, MS), (5, 5 * MS)):
        stream.at_ns += 30 * MS
        stream.timeline.read(stream.at_ns + stream.offset_ns, stream.at_ns)
        stamps = stream.timeline.many([stream.at_ns] * frames, wire_ns=MS)
        assert all(
            abs((after or 0) - (before or 0) - gap_ns) < MS // 2
            for before, after in pairwise(stamps)
        )


def test_what_waited_for_ten_seconds_is_stamped_as_of_then_if_all_of_it_is_there() -> None:
    stream = MadeStream()
    before = steady(stream, 50, 10 * MS)[-1]
    late = stream.read(found(10 * S + 4 * MS, 1000))
    assert all(9.9 < gap < 10.1 for gap in gaps_of([before, late]))
    assert 890 <= stream.timeline.late <= 910
    assert gaps_of([late, stream.read(found(10 * MS))])[0] < 20.0


def test_what_waited_for_ten_seconds_is_dropped_if_some_of_it_is_missing() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    assert stream.read(found(10 * S, 320)).stamps == [None] * 320
    assert stream.timeline.late == 320
    # What is still behind it comes in a hurry. What comes alone is of now.
    assert stream.read(found(MS, 20)).stamps == [None] * 20
    now = stream.read(found(10 * MS))
    assert now.stamps == [now.date_ns]
    assert None not in stream.read(found(30 * MS, 3)).stamps


def test_a_silent_device_is_no_stall() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    read = stream.read(found(20 * S, 3, looks=True)._replace(pause_ns=2 * S))
    assert None not in read.stamps
    assert stream.timeline.late == 0


def test_a_frame_begun_before_a_stall_keeps_the_time_of_its_beginning() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    begun = stream.read(found(10 * MS, 1, begins=True))
    late = stream.read(found(10 * S, 100))
    assert late.stamps == [begun.date_ns, *[None] * 99]


def test_a_frame_begun_in_a_stall_is_dropped_with_it_also_where_each_takes_several_reads() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    assert stream.read(found(10 * S, 100, begins=True)).stamps == [None] * 100
    # From here on each frame ends in the read after the one that it began in.
    assert stream.read(found(10 * MS, 1, begins=True)).stamps == [None]
    for _ in range(3):
        before = stream.at_ns + stream.offset_ns - 1_000
        assert stream.read(found(10 * MS, 1, begins=True)).stamps == [before]
        assert stream.timeline.late == 0


def test_a_slow_device_after_a_stall_is_stamped_when_it_was_due() -> None:
    stream = MadeStream()
    last = steady(stream, 20, S)[-1]
    late = stream.read(found(3 * S + S // 2, 3))
    assert gaps_of([last, late]) == [1000.0] * 3


def test_without_a_usual_interval_nobody_knows_how_far_frames_are_apart() -> None:
    stream = MadeStream()
    assert gaps_of([stream.read(found(900 * MS, 3))]) == [10.0, 10.0]
    assert stream.read(found(2 * S, 3)).stamps == [None] * 3


def test_a_clock_that_is_slewed_is_not_set() -> None:
    stream = MadeStream()
    for ppm in (500, -500):
        for pause_ns in (MS, 10 * MS, 900 * MS, 60 * S):
            for _ in range(50):
                stream.offset_ns += pause_ns * ppm // 1_000_000
                assert stream.read(found(pause_ns, looks=True)).step_ns == 0


def test_a_step_that_is_too_small_to_tell_stops_the_stamps_for_one_read_at_most() -> None:
    stream = MadeStream()
    steady(stream, 50, MS // 10)
    stream.offset_ns -= MS * 9 // 10
    reads = steady(stream, 20, MS // 10)
    assert [read.step_ns < 0 for read in reads] == [False, True, *[False] * 18]
    assert all(read.stamps == [read.date_ns] for read in reads[1:])


def test_clocks_that_stand_still_do_not_stop_the_stamps_from_rising() -> None:
    stream = MadeStream()
    steady(stream, 3, MS)
    at_ns = stream.at_ns
    stamps = []
    for _ in range(5):
        date_ns = at_ns + stream.offset_ns
        stream.timeline.read(date_ns, at_ns)
        assert stream.timeline.step(at_ns, date_ns, at_ns) == 0
        stamps += stream.timeline.many([at_ns] * 2)
    assert all(gap > 0 for gap in gaps_of([Stamped(stamps, 0, 0, 0, 0, 0, 0, 0, 0)]))


def test_what_waited_while_the_machine_slept_is_late() -> None:
    stream = MadeStream()
    steady(stream, 50, 10 * MS)
    at_ns, offset_ns = stream.at_ns + 300 * MS, stream.offset_ns + 3600 * S
    stream.timeline.read(at_ns + offset_ns, at_ns)
    assert stream.timeline.step(at_ns, at_ns + offset_ns, at_ns) == 3600 * S
    stream.timeline.sleep(3600 * S)
    assert stream.timeline.many([at_ns] * 20) == [None] * 20
    stream.at_ns, stream.offset_ns = at_ns, offset_ns
    now = stream.read(found(10 * MS))
    assert now.stamps == [now.date_ns]


def test_who_keeps_all_is_given_a_stamp_for_what_nobody_can_date() -> None:
    timeline = Timeline(Rhythm(), keeps_all=True)
    timeline.begin(0)
    timeline.read(100 * S, 10 * S)
    assert timeline.many([10 * S] * 3) == [100 * S - 20 * MS, 100 * S - 10 * MS, 100 * S]
    assert timeline.late == 3
