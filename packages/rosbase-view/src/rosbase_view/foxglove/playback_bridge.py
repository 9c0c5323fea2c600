"""A recording, played to the clients of the server."""

import math
import threading
from collections import deque
from collections.abc import Callable, Sequence

from attrs import evolve
from foxglove.websocket import (
    ChannelView,
    Client,
    PlaybackCommand,
    PlaybackControlRequest,
    PlaybackState,
    PlaybackStatus,
    ServerListener,
)

from rosbase import Clock, ConfigurationError, background_thread
from rosbase_view.foxglove.channels import Channels
from rosbase_view.foxglove.graph import links
from rosbase_view.foxglove.notices import Notices
from rosbase_view.foxglove.server import Server
from rosbase_view.foxglove.wanted import TURN_EVERY_NS, Listened
from rosbase_view.reports import Heard, Position, Report, Said, Survey, TopicKey
from rosbase_view.source import Gaze, Pace, Playback, Source

__all__ = ["PlaybackBridge"]

_OPENING_S = 30.0
_LOOK_S = 0.02
# Clients forget what they have when they hear of a jump, so what follows must not come before.
_AFTER_NS = 20_000_000


class PlaybackBridge:
    """Sends what a source plays, and moves it as clients ask.

    It begins to play when the first client listens: not every viewer has controls for it.
    """

    def __init__(
        self,
        source: Source,
        playback: Playback,
        clock: Clock,
        on_failure: Callable[[Exception], object],
    ) -> None:
        """Prepare to play.

        Args:
            source: The recording.
            playback: Its controls.
            clock: Tells when to move.
            on_failure: Takes an error that should not happen, with which a thread has ended.
        """
        self._source, self._playback = source, playback
        self._clock, self._fail = clock, on_failure
        self._server = Server()
        self._notices = Notices(self._server)
        self._channels = Channels(self._server, self._notices, lambda key, _: source.schema_of(key))
        self._position: Position | None = None
        self._listened = Listened({}, frozenset())
        self._last: dict[TopicKey, Heard] = {}
        # When the last transform of each Imu was sent, in the time of the recording.
        self._turned_ns: dict[TopicKey, int] = {}
        self._has_begun = False
        self._poke = threading.Event()
        # With the time at which each is obeyed.
        self._requests: deque[tuple[int, PlaybackControlRequest]] = deque()
        self._is_closed = False
        self._thread = background_thread(self._run, "rosbase view playback")

    def start(self, name: str, host: str, port: int) -> int:
        """Open the recording and listen; return the port.

        Raises:
            ConfigurationError: The port is in use, or the recording cannot be opened.
        """
        self._source.start(self._poke.set)
        position = self._first_position()
        listener = _Listener(self._channels, self._ask, self._poke.set)
        time_range = position.begin_ns, position.end_ns
        found = self._server.start(name, host, port, listener, time_range)
        self._thread.start()
        return found

    def close(self) -> None:
        """End all connections and threads. Idempotent."""
        self._is_closed = True
        self._poke.set()
        if self._thread.ident is not None:
            self._thread.join()
        self._server.stop()
        self._source.close()

    def _first_position(self) -> Position:
        """Wait until the source tells where the recording begins and ends."""
        while self._position is None:
            self._poke.clear()
            self._take(self._source.take())
            if self._position is None and not self._poke.wait(_OPENING_S):
                raise ConfigurationError("the recording cannot be opened")
        return self._position

    def _run(self) -> None:
        try:
            while not self._is_closed:
                self._poke.wait(_LOOK_S)
                self._poke.clear()
                self._step()
        except Exception as error:
            self._fail(error)

    def _step(self) -> None:
        self._take(self._source.take())
        listened = self._channels.listened()
        if listened != self._listened:
            self._send_again(listened)
            self._listened = listened
            topics = frozenset(listened.topics) | listened.turned
            self._source.look_at(Gaze(topics=topics, pace=Pace.ALL))
        while self._requests and self._clock.monotonic_ns() >= self._requests[0][0]:
            self._obey(self._requests.popleft()[1])
        if (listened.topics or listened.turned) and not self._has_begun:
            self._has_begun = True
            self._playback.play()

    def _obey(self, request: PlaybackControlRequest) -> None:
        """Do what a client asks. All clients have been told."""
        self._has_begun = True
        if _is_rate(request.playback_speed):
            self._playback.set_rate(request.playback_speed)
        if request.seek_time is not None:
            self._playback.seek(request.seek_time)
            self._last.clear()
        if request.playback_command == PlaybackCommand.Pause:
            self._playback.pause()
        elif request.seek_time is None or not self._is_end(request.seek_time):
            # From the end, a source would play from the beginning.
            self._playback.play()

    def _is_end(self, time_ns: int) -> bool:
        return self._position is not None and time_ns >= self._position.end_ns

    def _ask(self, request: PlaybackControlRequest) -> PlaybackState | None:
        """Take what a client asks, on a thread of the SDK; return what will be."""
        position = self._position
        if position is None:
            return None
        self._requests.append((self._clock.monotonic_ns() + _AFTER_NS, request))
        did_seek = request.seek_time is not None
        return _state(_asked(position, request), request.request_id, did_seek=did_seek)

    def _take(self, reports: Sequence[Report]) -> None:
        for report in reports:
            if isinstance(report, Heard):
                self._send(report)
            elif isinstance(report, Survey):
                topics = self._channels.update(report)
                self._server.send_links(links(topics, {}))
            elif isinstance(report, Position):
                self._move(report)
            elif isinstance(report, Said) and report.is_error:
                self._notices.say("recording", report.text)

    @property
    def _is_leaving(self) -> bool:
        """Whether clients have been told that the time at which the recording is will be left."""
        return any(request.seek_time is not None for _, request in list(self._requests))

    def _send(self, heard: Heard) -> None:
        if self._is_leaving:
            return
        stamp_ns = heard.stamp_ns or 0
        self._last[heard.topic] = heard
        if heard.topic in self._listened.topics:
            self._channels.send(heard.topic, stamp_ns, heard.data)
        if heard.topic in self._listened.turned and self._is_turn_due(heard.topic, stamp_ns):
            self._channels.send_transform(heard.topic, stamp_ns, heard.data)
        if heard.dropped:
            self._channels.count_dropped(heard.topic, None, heard.dropped)

    def _is_turn_due(self, topic: TopicKey, stamp_ns: int) -> bool:
        """Return whether a transform is due, after a jump too."""
        before_ns = self._turned_ns.get(topic, -TURN_EVERY_NS)
        if 0 <= stamp_ns - before_ns < TURN_EVERY_NS:
            return False
        self._turned_ns[topic] = stamp_ns
        return True

    def _send_again(self, listened: Listened) -> None:
        """Send the last messages of topics to which another client has begun to listen.

        It may be one that was sent only once, such as a map. The others get it again.
        """
        for topic, listeners in listened.topics.items():
            before = self._listened.topics.get(topic)
            heard = self._last.get(topic)
            if before is not None and before < listeners and heard is not None:
                self._channels.send(topic, heard.stamp_ns or 0, heard.data)

    def _move(self, position: Position) -> None:
        before, self._position = self._position, position
        if self._is_leaving:
            return
        self._server.send_time(position.now_ns)
        if before is None or _status(before) != _status(position) or before.rate != position.rate:
            self._server.send_playback(_state(position, None))


class _Listener(ServerListener):
    """Takes what clients ask for, on threads of the SDK."""

    def __init__(
        self,
        channels: Channels,
        ask: Callable[[PlaybackControlRequest], PlaybackState | None],
        poke: Callable[[], object],
    ) -> None:
        self._channels, self._ask, self._poke = channels, ask, poke

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:
        """Begin to hear a topic."""
        self._channels.count_listener(channel.topic)
        self._poke()

    def on_unsubscribe(self, client: Client, channel: ChannelView) -> None:
        """End hearing a topic, if nobody else listens."""
        self._poke()

    def on_playback_control_request(
        self, playback_control_request: PlaybackControlRequest
    ) -> PlaybackState | None:
        """Move soon; return the state that is then, which all clients are told."""
        return self._ask(playback_control_request)


def _status(position: Position) -> PlaybackStatus:
    if position.is_playing:
        return PlaybackStatus.Playing
    is_over = position.now_ns >= position.end_ns
    return PlaybackStatus.Ended if is_over else PlaybackStatus.Paused


def _state(position: Position, request: str | None, *, did_seek: bool = False) -> PlaybackState:
    return PlaybackState(_status(position), position.now_ns, position.rate, did_seek, request)


def _is_rate(speed: float) -> bool:
    return 0.0 < speed < math.inf


def _asked(position: Position, request: PlaybackControlRequest) -> Position:
    """Return where a recording is once a request is obeyed."""
    now_ns = position.now_ns if request.seek_time is None else request.seek_time
    return evolve(
        position,
        now_ns=min(max(now_ns, position.begin_ns), position.end_ns),
        is_playing=request.playback_command == PlaybackCommand.Play,
        rate=request.playback_speed if _is_rate(request.playback_speed) else position.rate,
    )
