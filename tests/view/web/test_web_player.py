"""Controls of a recording."""

from collections.abc import Iterator

import pytest

from rosbase_view.reports import Position
from rosbase_view.web.player import Player, PlayOrPause, Seek, play
from rosbase_view.web.server import GuardedServer, bind
from support.viewing import SECOND, MadePlayback

BEGIN_NS = 1_000 * SECOND
STANDING = Position(BEGIN_NS + 3 * SECOND, BEGIN_NS, BEGIN_NS + 10 * SECOND, is_playing=False)
PLAYING = Position(BEGIN_NS + 3 * SECOND, BEGIN_NS, BEGIN_NS + 10 * SECOND, is_playing=True)


@pytest.fixture
def server() -> Iterator[GuardedServer]:
    server = GuardedServer(bind("127.0.0.1", 0), "secret-secret-16", "robot")
    yield server
    server.stop()


def test_one_button_plays_and_pauses_and_the_slider_seeks() -> None:
    playback = MadePlayback()
    play(PlayOrPause(), playback, STANDING)
    play(PlayOrPause(), playback, PLAYING)
    play(Seek(2.5), playback, PLAYING)
    assert playback.calls == [("play",), ("pause",), ("seek", BEGIN_NS + 5 * SECOND // 2)]


def test_the_controls_show_where_the_recording_is(server: GuardedServer) -> None:
    player = Player(server.gui, print)
    assert not player.slider.visible
    player.show(PLAYING)
    assert (player.slider.max, player.slider.value, player.button.label) == (10.0, 3.0, "pause")
    player.show(STANDING)
    assert player.button.label == "play"
    player.show(None)
    assert not player.slider.visible
    assert not player.button.visible


def test_an_empty_recording_has_a_slider_too(server: GuardedServer) -> None:
    player = Player(server.gui, print)
    player.show(Position(0, 0, 0, is_playing=False))
    assert player.slider.value == 0.0


def test_the_slider_reaches_the_end_of_any_recording(server: GuardedServer) -> None:
    player = Player(server.gui, print)
    end_ns = 10_063_568_000
    player.show(Position(end_ns, 0, end_ns, is_playing=False))
    assert (player.slider.max, player.slider.value) == (10.1, 10.1)
