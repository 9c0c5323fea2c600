"""The source of a recording."""

import threading
from collections.abc import Callable, Iterable, Iterator, Sequence

from rosbase import Clock, ControlError, SystemClock, background_thread
from rosbase.control.shapes import Topic
from rosbase_view.recorded.outbox import Outbox
from rosbase_view.recorded.past import read_past
from rosbase_view.recorded.playhead import Playhead
from rosbase_view.recorded.recording import RecordedMessage, RecordedTopic, Recording
from rosbase_view.recorded.rosout import LOG, record_of
from rosbase_view.reports import Heard, Position, Report, Survey, TopicKey
from rosbase_view.source import Change, Gaze, Pace

__all__ = ["RecordedSource"]

_NO_PID = 0
# The position is reported so often.
_TURN_NS = 50_000_000
_COUNT_NS = 200_000_000
# A machine that cannot read so fast plays more slowly.
_MOST_BEHIND_NS = 200_000_000
# What a view gets at once.
_LEAST_TURN_NS = 5_000_000
_MOST_AT_ONCE, _MOST_BYTES = 500, 4 * 1024 * 1024


class RecordedSource:
    """Plays a recording; implements `Source` and `Playback`. One thread reads the file."""

    can_change = False

    def __init__(self, recording: Recording, clock: Clock | None = None) -> None:
        """Prepare to play from the beginning.

        Args:
            recording: What is played. It is closed with the source.
            clock: Tells how time passes.
        """
        self._recording = recording
        self._clock = clock or SystemClock()
        self._topics = {(topic.name, _NO_PID): topic for topic in recording.topics}
        self._changed = threading.Condition()
        # All of these belong to the lock of the condition.
        self._head = Playhead(recording.begin_ns, recording.end_ns)
        self._outbox = Outbox(self._topics)
        self._is_surveyed = False
        # Where to read from; None while the file is read from there.
        self._target_ns: int | None = recording.begin_ns
        self._fresh: frozenset[TopicKey] = frozenset()
        self._has_jumped = False
        self._counted_ns = (0, recording.begin_ns)
        self._on_news: Callable[[], object] = lambda: None
        self._is_closed = False
        self._failure: Exception | None = None
        self._thread = background_thread(self._run, "rosbase view recording")

    @property
    def playback(self) -> "RecordedSource":
        """Return the controls of the recording."""
        return self

    def start(self, on_news: Callable[[], object] | None = None) -> None:
        """Open it. It stands at its beginning until it is played.

        Args:
            on_news: Called on any thread when there is something to take.
        """
        if on_news is not None:
            self._on_news = on_news
        self._thread.start()
        self._on_news()

    def take(self) -> Sequence[Report]:
        """Return what was reported since the last call.

        Raises:
            Exception: The recording could not be read any more.
        """
        with self._changed:
            if self._failure is not None:
                raise self._failure
            now_ns = self._clock.monotonic_ns()
            found: list[Report] = [] if self._is_surveyed else [self._survey()]
            self._is_surveyed = True
            found += self._outbox.take_past(self._head.at(now_ns))
            found += self._counts(now_ns)
            if self._outbox.is_full:
                self._changed.notify_all()
            found += self._outbox.take_heard()
            found.append(self._position(now_ns))
            return found

    def look_at(self, gaze: Gaze) -> None:
        """Report the messages of these topics; at once, the last one of each new topic."""
        with self._changed:
            self._fresh |= gaze.topics - self._outbox.gaze.topics
            self._outbox.gaze = gaze
            if self._fresh:
                self._changed.notify_all()

    def schema_of(self, topic: TopicKey) -> tuple[str, str]:
        """Return the type of the messages, and its schema.

        Raises:
            ControlError: There is no such topic.
        """
        found = self._topics.get(topic)
        if found is None:
            raise ControlError(f"there is no topic {topic[0]}", "unknown")
        return found.type, found.schema

    def change(self, change: Change) -> None:
        """Do nothing: a recording cannot be changed."""

    def close(self) -> None:
        """End the thread, and close the recording. Idempotent."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        if self._thread.ident is not None:
            self._thread.join()
        self._recording.close()

    def play(self) -> None:
        """Go on; from the beginning, if the end was reached."""
        with self._changed:
            now_ns = self._clock.monotonic_ns()
            if self._head.at(now_ns) >= self._head.end_ns:
                self._move(self._head.begin_ns, now_ns)
            self._head.play(now_ns)
            self._changed.notify_all()
        self._on_news()

    def pause(self) -> None:
        """Stand still."""
        with self._changed:
            self._head.pause(self._clock.monotonic_ns())
            self._changed.notify_all()
        self._on_news()

    def seek(self, time_ns: int) -> None:
        """Go to a time. Messages of the time before are not reported any more."""
        with self._changed:
            self._move(time_ns, self._clock.monotonic_ns())
            self._changed.notify_all()
        self._on_news()

    def set_rate(self, rate: float) -> None:
        """Set the speed; 1 is the speed of the recording."""
        with self._changed:
            self._head.set_rate(rate, self._clock.monotonic_ns())
            self._changed.notify_all()
        self._on_news()

    # With the lock.

    def _move(self, to_ns: int, now_ns: int) -> None:
        self._head.seek(to_ns, now_ns)
        self._outbox.clear()
        self._target_ns = self._head.at(now_ns)
        self._has_jumped = True
        self._counted_ns = now_ns, self._target_ns

    def _survey(self) -> Survey:
        return Survey((), {key: _shape(topic) for key, topic in self._topics.items()}, (), ())

    def _position(self, now_ns: int) -> Position:
        head = self._head
        return Position(head.at(now_ns), head.begin_ns, head.end_ns, head.is_playing, head.rate)

    def _counts(self, now_ns: int) -> Sequence[Report]:
        then_ns, from_ns = self._counted_ns
        at_ns = self._head.at(now_ns)
        if now_ns - then_ns < _COUNT_NS or at_ns <= from_ns:
            return ()
        self._counted_ns = now_ns, at_ns
        return self._outbox.take_counts(at_ns, (at_ns - from_ns) / 1e9)

    # On the thread that reads.

    def _run(self) -> None:
        try:
            self._play()
        except Exception as error:
            with self._changed:
                self._failure = error
            self._on_news()

    def _play(self) -> None:
        messages: Iterator[RecordedMessage] = iter(())
        following: RecordedMessage | None = None
        while True:
            with self._changed:
                if self._is_closed:
                    return
                target_ns, self._target_ns = self._target_ns, None
                fresh, self._fresh = self._fresh, frozenset()
                has_jumped, self._has_jumped = self._has_jumped, False
                # Who wants each message needs no rates.
                needs_past = has_jumped and self._outbox.gaze.pace is Pace.NEWEST
                if target_ns is not None:
                    fresh = self._outbox.gaze.topics
            if target_ns is not None:
                messages = self._recording.messages(target_ns)
                following = next(messages, None)
            elif following is not None:
                target_ns = following.stamp_ns
            else:
                target_ns = self._recording.end_ns + 1
            if fresh or needs_past:
                latest = self._recording.latest(target_ns)
                self._show_latest(latest, fresh)
                if needs_past:
                    self._show_past(target_ns, latest)
            batch, following = self._read(messages, following)
            if self._deliver(batch, following):
                self._on_news()
            self._wait(following)

    def _show_past(self, to_ns: int, latest: Sequence[RecordedMessage]) -> None:
        """Report the rates, the ages and the log of the time before a jump's end."""

        def is_left() -> bool:
            return self._is_closed or self._target_ns is not None

        past = read_past(self._recording, to_ns, latest, self._is_log, is_left)
        if past is None:
            return
        heard = [one for message in past.log if (one := self._heard(message)) is not None]
        with self._changed:
            if self._target_ns is not None:
                return
            self._outbox.begin([((one.topic, _NO_PID), one) for one in past.windows])
            self._log(heard)
        self._on_news()

    def _is_log(self, topic: str) -> bool:
        found = self._topics.get((topic, _NO_PID))
        return found is not None and found.type == LOG

    def _log(self, heard: Iterable[Heard]) -> None:
        """Report those messages that are records of the log. With the lock."""
        for one in heard:
            if one.type == LOG and (record := record_of(one)) is not None:
                self._outbox.add_record(record)

    def _show_latest(self, latest: Sequence[RecordedMessage], topics: frozenset[TopicKey]) -> None:
        """Report what was known before a time of topics that are looked at only now."""
        with self._changed:
            if self._target_ns is not None:
                return
            for message in latest:
                if (heard := self._heard(message)) is not None and heard.topic in topics:
                    self._outbox.show(heard)
        self._on_news()

    def _read(
        self, messages: Iterator[RecordedMessage], following: RecordedMessage | None
    ) -> tuple[list[Heard], RecordedMessage | None]:
        """Return the messages that are due, and the one after them."""
        with self._changed:
            at_ns = self._head.at(self._clock.monotonic_ns())
            if not self._head.is_playing or self._outbox.is_full:
                return [], following
        batch: list[Heard] = []
        size = 0
        while following is not None and following.stamp_ns <= at_ns:
            if len(batch) >= _MOST_AT_ONCE or size >= _MOST_BYTES:
                break
            if (heard := self._heard(following)) is not None:
                batch.append(heard)
                size += len(heard.data)
            following = next(messages, None)
        return batch, following

    def _deliver(self, batch: Sequence[Heard], following: RecordedMessage | None) -> bool:
        """Report messages; return whether there is any news."""
        with self._changed:
            if self._target_ns is not None:
                # They are of a time that was left while they were read.
                return True
            for heard in batch:
                self._outbox.add(heard)
            # A topic that was added during the read has got its latest message with these.
            self._fresh -= {heard.topic for heard in batch}
            if self._outbox.gaze.pace is Pace.NEWEST:
                self._log(batch)
            was_playing = self._head.is_playing
            self._settle(following)
            return was_playing or bool(batch)

    def _settle(self, following: RecordedMessage | None) -> None:
        """Stop at the end, and do not run away from what is not read yet."""
        now_ns = self._clock.monotonic_ns()
        at_ns = self._head.at(now_ns)
        if not self._head.is_playing:
            return
        if following is None and at_ns >= self._head.end_ns:
            self._head.pause(now_ns)
        elif following is not None and at_ns - following.stamp_ns > _MOST_BEHIND_NS:
            self._head.seek(following.stamp_ns, now_ns)

    def _wait(self, following: RecordedMessage | None) -> None:
        """Wait until the next message is due, or something else is asked for."""
        with self._changed:
            if self._is_closed or self._target_ns is not None or self._fresh:
                return
            if not self._head.is_playing:
                self._changed.wait()
                return
            due_ns = _TURN_NS
            if following is not None and not self._outbox.is_full:
                now_ns = self._clock.monotonic_ns()
                due_ns = min(due_ns, self._head.due_ns(following.stamp_ns, now_ns))
            if due_ns > 0:
                self._changed.wait(max(due_ns, _LEAST_TURN_NS) / 1e9)

    def _heard(self, message: RecordedMessage) -> Heard | None:
        key = message.topic, _NO_PID
        topic = self._topics.get(key)
        if topic is None:
            return None
        return Heard(key, topic.type, topic.schema, message.stamp_ns, message.data)


def _shape(topic: RecordedTopic) -> Topic:
    """Return a topic as programs tell of it."""
    return {"name": topic.name, "types": [topic.type], "publishers": [], "subscriptions": []}
