"""A recording as a source: what a view gets while it plays, stands and jumps."""

from collections.abc import Callable, Iterator

import pytest

from rosbase import ControlError
from rosbase.messages import String
from rosbase.wire import deserialize
from rosbase_view.known import Known
from rosbase_view.recorded.recording import RecordedMessage
from rosbase_view.recorded.source import RecordedSource
from rosbase_view.reports import Counted, Heard, Position, Report, Survey, TopicKey
from rosbase_view.source import ChangeState, Gaze, Pace, Source
from support.made_recording import BEGIN_NS, STEP_NS, MadeRecording, number_of
from support.waiting import wait_until

IMU, MODEL = ("/imu/data", 0), ("/model", 0)
COUNT = 300


class Taking:
    """Takes the reports of a source, and keeps them by kind."""

    def __init__(self, recording: MadeRecording) -> None:
        self.recording = recording
        self.source = RecordedSource(recording)
        self.news = 0
        self.surveys: list[Survey] = []
        self.positions: list[Position] = []
        self.counts: list[Counted] = []
        self.heard: dict[TopicKey, list[Heard]] = {IMU: [], MODEL: []}

    def start(self, *topics: TopicKey, pace: Pace = Pace.ALL) -> None:
        self.source.start(self._count_news)
        self.source.look_at(Gaze(topics=frozenset(topics), pace=pace))

    def _count_news(self) -> None:
        self.news += 1

    def until(self, condition: Callable[[], object], what: str) -> None:
        def step() -> object:
            for report in self.source.take():
                self._keep(report)
            return condition()

        wait_until(step, what)

    def _keep(self, report: Report) -> None:
        if isinstance(report, Heard):
            self.heard[report.topic].append(report)
        elif isinstance(report, Position):
            self.positions.append(report)
        elif isinstance(report, Counted):
            self.counts.append(report)
        elif isinstance(report, Survey):
            self.surveys.append(report)

    @property
    def numbers(self) -> list[int]:
        return [number_of(one.data) for one in self.heard[IMU]]

    @property
    def is_over(self) -> bool:
        last = self.positions[-1]
        return not last.is_playing and last.now_ns == last.end_ns


@pytest.fixture
def taking() -> Iterator[Taking]:
    found = Taking(MadeRecording(COUNT))
    yield found
    found.source.close()
    assert found.recording.is_closed


def test_it_is_a_source(taking: Taking) -> None:
    source: Source = taking.source
    assert source.playback is not None
    assert not source.can_change
    source.change(ChangeState(("arm", 0), "activate"))
    assert source.schema_of(MODEL) == ("std_msgs/msg/String", "string data\n")
    with pytest.raises(ControlError, match="no topic /nothing"):
        source.schema_of(("/nothing", 0))
    source.start()


def test_it_stands_at_its_beginning_until_it_is_played(taking: Taking) -> None:
    taking.start(IMU)
    taking.until(lambda: len(taking.positions) > 3, "positions")
    assert set(taking.surveys[0].topics) == {IMU, MODEL}
    assert len(taking.surveys) == 1
    assert taking.positions[-1] == Position(
        BEGIN_NS, BEGIN_NS, BEGIN_NS + (COUNT - 1) * STEP_NS, is_playing=False
    )
    assert not taking.numbers


def test_it_is_played_as_fast_as_it_was_recorded_with_each_message_once(taking: Taking) -> None:
    taking.start(IMU, MODEL)
    taking.source.play()
    taking.until(lambda: taking.is_over, "the end")
    assert taking.numbers == list(range(COUNT))
    assert deserialize(taking.heard[MODEL][0].data, String).data == "a board"
    assert len(taking.heard[MODEL]) == 1
    moments = [one.now_ns for one in taking.positions]
    assert moments == sorted(moments)
    # Rates are of the time of the recording.
    counted = [one for one in taking.counts if one.topic == IMU]
    assert sum(one.count for one in counted) / sum(one.seconds for one in counted) == pytest.approx(
        100.0, rel=0.2
    )


def test_a_topic_that_nobody_looks_at_is_counted_and_not_reported(taking: Taking) -> None:
    taking.start(MODEL)
    taking.source.set_rate(10.0)
    taking.source.play()
    taking.until(lambda: taking.is_over, "the end")
    assert not taking.numbers
    assert sum(one.count for one in taking.counts if one.topic == IMU) > 0


def test_it_stands_still_and_goes_on_without_a_gap(taking: Taking) -> None:
    taking.start(IMU)
    taking.source.set_rate(4.0)
    taking.source.play()
    taking.until(lambda: len(taking.numbers) > 50, "messages")
    taking.source.pause()
    taking.until(lambda: not taking.positions[-1].is_playing, "the pause")
    count, moment = len(taking.numbers), taking.positions[-1].now_ns
    seen = len(taking.positions)
    taking.until(lambda: len(taking.positions) > seen + 20, "some looks")
    # One batch may have been on its way.
    assert len(taking.numbers) <= count + 500
    assert taking.positions[-1].now_ns == moment
    taking.source.play()
    taking.until(lambda: taking.is_over, "the end")
    assert taking.numbers == list(range(COUNT))


def test_a_jump_reports_what_was_known_then_and_goes_on_from_there(taking: Taking) -> None:
    taking.start(IMU, MODEL)
    taking.source.seek(BEGIN_NS + 200 * STEP_NS)
    taking.until(lambda: taking.numbers and taking.heard[MODEL], "the last messages")
    assert taking.numbers == [199]
    taking.source.play()
    taking.until(lambda: taking.is_over, "the end")
    assert taking.numbers == list(range(199, COUNT))
    # Backwards too, and after the end.
    taking.heard[IMU].clear()
    taking.source.seek(BEGIN_NS + 290 * STEP_NS)
    taking.source.play()
    taking.until(lambda: taking.is_over and taking.numbers[-1:] == [COUNT - 1], "the end again")
    assert taking.numbers == list(range(289, COUNT))


@pytest.mark.parametrize("target", [250, 10_050, 0])
def test_after_a_jump_while_it_stands_rates_ages_and_log_are_those_of_then(target: int) -> None:
    source = RecordedSource(MadeRecording(20_000, has_log=True))
    known = Known()

    def step() -> object:
        known.take(source.take(), 0)
        return jumped_ns == (known.position.now_ns if known.position else 0) and (
            bool(known.log) or target == 0
        )

    try:
        source.start()
        jumped_ns = BEGIN_NS + 15_050 * STEP_NS
        source.seek(jumped_ns)
        wait_until(step, "the log")
        jumped_ns = BEGIN_NS + target * STEP_NS
        known.log.clear()
        source.seek(jumped_ns)
        wait_until(step, "the log of another time")
        wait_until(lambda: step() and known.topics[IMU].total in (0, min(target, 500)), "counts")
    finally:
        source.close()
    topic = known.topics[IMU]
    assert topic.rate_hz(jumped_ns) == (pytest.approx(100.0) if target else None)
    assert topic.age_ns(jumped_ns) == (STEP_NS if target else None)
    # Published once, long before.
    assert known.topics[MODEL].age_ns(jumped_ns) == (target * STEP_NS or None)
    texts = [one["text"] for one in known.log]
    first = max(0, target // 100 - 4 if target > 500 else 0)
    assert texts == [f"record {number}" for number in range(first, -(-target // 100))]
    if texts:
        assert (known.log[0]["level"], known.log[0]["name"]) == (30, "imu")


def test_the_log_is_reported_while_it_is_played() -> None:
    source = RecordedSource(MadeRecording(COUNT, has_log=True))
    known = Known()

    def step() -> object:
        known.take(source.take(), 0)
        return len(known.log) == 3

    try:
        source.start()
        source.set_rate(10.0)
        source.play()
        wait_until(step, "three records")
    finally:
        source.close()
    assert [one["text"] for one in known.log] == ["record 0", "record 1", "record 2"]


def test_nothing_of_the_time_before_is_reported_after_a_jump(taking: Taking) -> None:
    taking.start(IMU)
    taking.source.play()
    taking.until(lambda: len(taking.numbers) > 20, "messages")
    for target in (250, 100, 280, 30, 270):
        taking.source.seek(BEGIN_NS + target * STEP_NS)
        taking.heard[IMU].clear()
        taking.until(lambda: len(taking.numbers) > 3, "messages from there")
        assert taking.numbers == list(range(target - 1, target - 1 + len(taking.numbers)))


def test_play_at_the_end_begins_again(taking: Taking) -> None:
    taking.start(IMU)
    taking.source.seek(2 * BEGIN_NS)
    taking.until(lambda: taking.is_over, "the end")
    taking.heard[IMU].clear()
    taking.source.play()
    taking.until(lambda: len(taking.numbers) > 5, "the beginning")
    assert taking.numbers[0] == 0


def test_a_topic_that_is_looked_at_later_has_its_last_message_at_once(taking: Taking) -> None:
    taking.start()
    taking.source.seek(BEGIN_NS + 50 * STEP_NS)
    taking.until(lambda: taking.positions[-1].now_ns > BEGIN_NS, "the place")
    assert not taking.heard[MODEL]
    taking.source.look_at(Gaze(topics=frozenset([MODEL])))
    taking.until(lambda: taking.heard[MODEL], "the last message")


def test_a_topic_that_is_looked_at_while_it_is_read_has_each_message_once() -> None:
    class Looked(MadeRecording):
        def messages(self, from_ns: int) -> Iterator[RecordedMessage]:
            for message in super().messages(from_ns):
                if self.read == 10:
                    sources[0].look_at(Gaze(topics=frozenset([IMU]), pace=Pace.ALL))
                yield message

    sources: list[RecordedSource] = []
    taking = Taking(Looked(COUNT))
    sources.append(taking.source)
    try:
        taking.start()
        taking.source.set_rate(20.0)
        taking.source.play()
        taking.until(lambda: taking.is_over, "the end")
        assert taking.numbers == list(range(taking.numbers[0], COUNT))
    finally:
        taking.source.close()


def test_only_the_newest_message_waits_if_that_is_enough(taking: Taking) -> None:
    taking.start(IMU, pace=Pace.NEWEST)
    taking.source.set_rate(1_000.0)
    taking.source.play()
    wait_until(lambda: taking.recording.read == COUNT, "the end of the file")
    taking.until(lambda: taking.is_over, "the end")
    assert taking.numbers == [COUNT - 1]


@pytest.mark.parametrize("padding", [0, 20_000])
def test_a_slow_view_loses_nothing_and_the_player_waits(padding: int) -> None:
    count = 10_000
    taking = Taking(MadeRecording(count, padding))
    try:
        taking.start(IMU)
        taking.source.set_rate(1e6)
        taking.source.play()
        wait_until(lambda: taking.recording.read > 700, "as many as there is room for")
        # Nobody takes them, so it goes no further than that.
        assert taking.recording.read <= 3_000
        taking.until(lambda: taking.is_over, "the end")
        assert taking.numbers == list(range(count))
    finally:
        taking.source.close()


def test_a_source_that_stands_makes_no_news(taking: Taking) -> None:
    taking.start(IMU)
    taking.until(lambda: len(taking.positions) > 3, "positions")
    before = taking.news
    taking.until(lambda: len(taking.positions) > 100, "many looks")
    assert taking.news == before


def test_a_file_that_cannot_be_read_any_more_ends_the_view() -> None:
    class Broken(MadeRecording):
        def messages(self, from_ns: int) -> "Iterator[object]":  # type: ignore[override]  # it is not reached
            raise OSError("the disk is gone")

    taking = Taking(Broken(COUNT))
    try:
        taking.start(IMU)
        with pytest.raises(OSError, match="the disk is gone"):
            taking.until(lambda: False, "the error")
    finally:
        taking.source.close()
