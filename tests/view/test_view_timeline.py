"""A recording in the terminal: its time line, its keys, and the time of its topics."""

import asyncio
from collections.abc import Awaitable, Callable

import pytest
from textual.pilot import Pilot

from rosbase_view.drawing.glyphs import ASCII, UNICODE
from rosbase_view.drawing.lines import cells, fitted, plain
from rosbase_view.known import Known
from rosbase_view.recorded.source import RecordedSource
from rosbase_view.reports import Counted, Position
from rosbase_view.terminal.app import ViewApp
from rosbase_view.terminal.lines_pane import LinesPane
from rosbase_view.timeline import draw_timeline, press
from support.made_recording import BEGIN_NS, MadeRecording
from support.viewing import IMU_TOPIC, MadeClock, survey

SECOND = 1_000_000_000


def position(at_s: float, *, is_playing: bool = True, rate: float = 1.0) -> Position:
    now_ns = BEGIN_NS + int(at_s * SECOND)
    return Position(now_ns, BEGIN_NS, BEGIN_NS + 100 * SECOND, is_playing, rate)


class Keys:
    """A playback that keeps what it was told."""

    def __init__(self) -> None:
        self.told: list[object] = []

    def play(self) -> None:
        self.told.append("play")

    def pause(self) -> None:
        self.told.append("pause")

    def seek(self, time_ns: int) -> None:
        self.told.append(("seek", (time_ns - BEGIN_NS) / SECOND))

    def set_rate(self, rate: float) -> None:
        self.told.append(("rate", rate))


@pytest.mark.parametrize("glyphs", [UNICODE, ASCII], ids=["unicode", "ascii"])
@pytest.mark.parametrize("width", [0, 10, 60, 80, 160])
def test_the_time_line_fits(width: int, glyphs: object) -> None:
    made = draw_timeline(position(25.0), width, glyphs)  # type: ignore[arg-type]  # one of two
    assert cells(plain(fitted(made, width))) == width


def test_the_time_line_has_state_time_share_speed_and_date() -> None:
    text = plain(draw_timeline(position(25.0, rate=2.0), 80, ASCII))
    assert text.startswith(" playing  0:25 / 1:40  [#")
    assert "]  x2  20" in text
    bar = text.partition("[")[2].partition("]")[0]
    assert bar.count("#") / len(bar) == pytest.approx(0.25, abs=0.05)
    assert plain(draw_timeline(position(0.0, is_playing=False), 80, ASCII)).startswith(" paused ")


@pytest.mark.parametrize(
    ("key", "told"),
    [
        ("space", "pause"),
        ("comma", ("seek", 20.0)),
        ("full_stop", ("seek", 30.0)),
        ("less_than_sign", ("seek", -35.0)),
        ("greater_than_sign", ("seek", 85.0)),
        ("minus", ("rate", 0.5)),
        ("plus", ("rate", 2.0)),
    ],
)
def test_keys_play_pause_seek_and_set_the_speed(key: str, told: object) -> None:
    keys = Keys()
    assert press(key, position(25.0), keys) is not None
    assert keys.told == [told]
    assert press("q", position(25.0), keys) is None


def test_keys_that_come_together_add_up() -> None:
    keys = Keys()
    moved = press("full_stop", position(25.0), keys)
    assert moved is not None
    press("full_stop", moved, keys)
    assert keys.told == [("seek", 30.0), ("seek", 35.0)]
    end = press("greater_than_sign", position(95.0), keys)
    assert end is not None
    assert end.now_ns == end.end_ns


def test_the_speed_has_limits() -> None:
    keys = Keys()
    press("plus", position(0.0, rate=64.0), keys)
    press("minus", position(0.0, rate=1 / 16), keys)
    press("space", position(0.0, is_playing=False), keys)
    assert keys.told == [("rate", 64.0), ("rate", 1 / 16), "play"]


def test_rates_and_ages_are_those_of_the_recording() -> None:
    known = Known()
    known.take([survey(), position(0.0)], 0)
    # Twice as fast as it was recorded: in each second of ours, two seconds of the recording.
    for step in range(1, 11):
        now_ns = step * SECOND // 2
        known.take([Counted(IMU_TOPIC, 200, 1.0, 0.0), position(float(step), rate=2.0)], now_ns)
    topic = known.topics[IMU_TOPIC]
    assert topic.rate_hz(known.time_ns(5 * SECOND)) == pytest.approx(200.0)
    # While it stands still, nothing grows old.
    assert topic.age_ns(known.time_ns(500 * SECOND)) == 0
    known.take([position(2.0)], 6 * SECOND)
    assert (topic.total, topic.age_ns(known.time_ns(6 * SECOND))) == (0, None)


def test_a_recording_is_played_paused_and_sought_with_keys() -> None:
    source = RecordedSource(MadeRecording(60_000), MadeClock())
    app = ViewApp(source, MadeClock(), ASCII, redraw_s=None)

    async def step(pilot: "Pilot[None]") -> list[str]:
        app.step()
        await pilot.pause()
        panes = [app.screen.query_one(f"#{name}", LinesPane) for name in ("list", "time")]
        return [
            pane.render_line(y).text.rstrip() for pane in panes for y in range(pane.size.height)
        ]

    async def until(pilot: "Pilot[None]", shown: Callable[[list[str]], bool]) -> None:
        async def go_on() -> None:
            while not shown(await step(pilot)):
                pass

        await asyncio.wait_for(go_on(), 20.0)

    async def play(pilot: "Pilot[None]") -> Awaitable[None] | None:
        await until(pilot, lambda lines: lines[-1].startswith(" playing  0:00 / 9:59"))
        assert any("> /imu/data" in line for line in await step(pilot))
        await pilot.press("full_stop", "full_stop", "greater_than_sign")
        await until(pilot, lambda lines: lines[-1].startswith(" playing  1:10 / 9:59"))
        await pilot.press("space")
        await until(pilot, lambda lines: lines[-1].startswith(" paused   1:10 / 9:59"))
        await pilot.press("plus")
        await until(pilot, lambda lines: "  x2  " in lines[-1])
        await pilot.press("4")
        await until(pilot, lambda lines: "  no record of /rosout yet" in lines)
        await pilot.press("2")
        await until(pilot, lambda lines: "  nodes: not shown for a recording" in lines)
        assert "lifecycle" not in plain(app.view.draw_status(80, 0)[0])
        return None

    async def run() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await play(pilot)

    asyncio.run(run())
