"""Hear the topics and the log of a program that already runs, through its control socket."""

import select
from collections.abc import Callable, Iterable

from rosbase import ControlError, DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from rosbase.clock import Clock
from rosbase.control.client import Stream
from rosbase.control.fleet import Fleet
from rosbase.control.gathering import connect_to
from rosbase.control.shapes import Endpoint, Topic
from rosbase_mcap.channel_table import LATCHED, QOS
from rosbase_mcap.log_channel import LOG_TOPIC, LogChannel
from rosbase_mcap.qos_text import profiles_text
from rosbase_mcap.recorder import Recorder

__all__ = ["AttachedTopics", "offered_profiles"]

# Messages of a topic that wait in the program while this process cannot run.
_MOST_WAITING = 10_000


class AttachedTopics:
    """Records what running programs publish. One thread uses it."""

    def __init__(
        self,
        fleet: Fleet,
        recorder: Recorder,
        clock: Clock,
        complain: Callable[[str], object],
        topics: Iterable[str] = (),
    ) -> None:
        """Prepare; `look` begins to hear.

        Args:
            fleet: The programs.
            recorder: Takes the messages.
            clock: Tells the date of messages that the program had kept.
            complain: Called with a line for each topic that cannot be heard.
            topics: Their full names; none stands for all.
        """
        self._fleet, self._recorder, self._clock = fleet, recorder, clock
        self._complain = complain
        self._wanted = frozenset(topics)
        self._heard: set[str] = set()
        self._streams: dict[int, tuple[Stream, Callable[[], int]]] = {}
        self._poll = select.poll()
        self._lost = 0

    @property
    def lost(self) -> int:
        """Number of messages that the programs dropped, because this process was too slow."""
        return self._lost

    @property
    def is_over(self) -> bool:
        """Whether everything that was heard has ended."""
        return not self._streams

    def look(self) -> None:
        """Hear the topics that are new. Call it again and again. Raises nothing."""
        try:
            topics = self._fleet.topics()
        except ControlError:
            # The program has ended, or is too busy to answer. Its streams tell which.
            return
        for topic in topics:
            name = topic["name"]
            if name in self._heard or (self._wanted and name not in self._wanted):
                continue
            if name == LOG_TOPIC:
                # Its lines come with the log.
                continue
            self._heard.add(name)
            try:
                self._hear(topic)
            except ControlError as error:
                self._complain(f"{name} is not recorded: {error}")

    def hear_log(self, pids: Iterable[int], channel: LogChannel) -> None:
        """Record the log of processes.

        Raises:
            ControlError: One has ended.
        """
        for pid in pids:
            stream = Stream(connect_to(pid), "log", {"follow": True, "last": 0})
            self._add(stream, _log_taker(stream, channel))

    def take(self, timeout_s: float) -> int:
        """Record what has come, waiting for it if need be; return the number of messages."""
        taken = 0
        for fd, _ in self._poll.poll(timeout_s * 1e3):
            stream, record = self._streams[fd]
            stream.read()
            taken += record()
            if stream.ended is not None:
                self._poll.unregister(fd)
                del self._streams[fd]
                stream.close()
        return taken

    def close(self) -> None:
        """Hear nothing any more."""
        for stream, _ in self._streams.values():
            stream.close()
        self._streams.clear()

    def _hear(self, topic: Topic) -> None:
        arguments = {"limit": _MOST_WAITING, "every_ns": 0}
        watch = self._fleet.watch("topic.echo", topic["name"], arguments)
        for stream in watch.streams:
            record = self._recorder.channel(
                topic["name"], stream.answer["type"], stream.answer["schema"], _metadata(topic)
            )
            self._add(stream, self._taker(stream, record))

    def _add(self, stream: Stream, record: Callable[[], int]) -> None:
        # Events may have come with the answer, and the socket does not tell of them again.
        record()
        if stream.ended is not None:
            stream.close()
            return
        self._streams[stream.connection.fileno()] = stream, record
        self._poll.register(stream.connection, select.POLLIN)

    def _taker(
        self, stream: Stream, record: Callable[[int, int, bytes], object]
    ) -> Callable[[], int]:
        """Return the function that records what has been read of a topic."""
        lost = 0

        def take() -> int:
            nonlocal lost
            events = stream.events()
            for event, data in events:
                # One that the publisher had kept has no date.
                stamp_ns = event["stamp_ns"] or self._clock.now_ns()
                record(stamp_ns, stamp_ns, data)
                if event["dropped"] > lost:
                    self._lost += event["dropped"] - lost
                    lost = event["dropped"]
            return len(events)

        return take


def offered_profiles(publishers: Iterable[Endpoint]) -> list[QoSProfile]:
    """Return the profiles of publishers, as far as they are known."""
    profiles = []
    for publisher in publishers:
        qos = publisher.get("qos")
        if qos:
            history = HistoryPolicy[qos["history"].upper()]
            profiles.append(
                QoSProfile(
                    qos["depth"] or 1,
                    reliability=ReliabilityPolicy[qos["reliability"].upper()],
                    durability=DurabilityPolicy[qos["durability"].upper()],
                    history=history,
                )
            )
    return profiles


def _metadata(topic: Topic) -> dict[str, str]:
    profiles = offered_profiles(topic["publishers"])
    metadata = {QOS: profiles_text(profiles)}
    if any(profile.is_latched for profile in profiles):
        metadata[LATCHED] = "true"
    return metadata


def _log_taker(stream: Stream, channel: LogChannel) -> Callable[[], int]:
    def take() -> int:
        events = stream.events()
        for event, _ in events:
            channel.write(event["stamp_ns"], event["level"], event["name"], event["text"])
        return len(events)

    return take
