"""The view on textual: keys, redraws, the editor, and pictures of the screen."""

import asyncio
import os
import re
import time
from collections.abc import Awaitable, Callable
from importlib.metadata import version
from pathlib import Path

import pytest
from textual.events import Key
from textual.pilot import Pilot
from textual.widgets import Input

from rosbase_view.drawing.glyphs import ASCII, UNICODE, Glyphs
from rosbase_view.reports import Counted, Said
from rosbase_view.source import ChangeState, Gaze, SetParameter
from rosbase_view.terminal.app import ViewApp
from rosbase_view.terminal.lines_pane import LinesPane
from rosbase_view.terminal.value_editor import ValueEditor
from support.viewing import ARM, IMU_TOPIC, PID, ROBOT, MadeClock, MadeSource, reports

ROOT = Path(__file__).parents[2]
PICTURES = Path(__file__).parent / "pictures"
# Not one of rosbase, which tests take out of the environment.
UPDATE = "UPDATE_PICTURES"
MADE_WITH = f"<!-- textual {version('textual')}, rich {version('rich')} -->\n"
SMALL, LARGE = (80, 24), (160, 50)
Play = Callable[[ViewApp, "Pilot[None]"], Awaitable[None]]
both_sizes = pytest.mark.parametrize("size", [SMALL, LARGE], ids=["80x24", "160x50"])


class Stage:
    """A view with a source and a clock of a test's own; a step is one redraw."""

    def __init__(self, glyphs: Glyphs = UNICODE, *, topics: int = 5) -> None:
        self.source, self.clock = MadeSource(), MadeClock()
        self.source.waiting = reports(topics)
        self.app = ViewApp(self.source, self.clock, glyphs, redraw_s=None)

    def play(self, play: Play, size: tuple[int, int] = SMALL) -> None:
        """Runs the view without a terminal, from its first step on."""

        async def run() -> None:
            async with self.app.run_test(size=size) as pilot:
                await self.step(pilot)
                await play(self.app, pilot)

        asyncio.run(run())

    async def step(self, pilot: "Pilot[None]") -> None:
        self.app.step()
        await pilot.pause()


async def until(pilot: "Pilot[None]", condition: Callable[[], bool]) -> None:
    """Lets the view go on until the condition holds."""

    async def go_on() -> None:
        while not condition():
            await pilot.pause()

    await asyncio.wait_for(go_on(), 20.0)


def text_of(app: ViewApp) -> list[str]:
    """What the screen shows, line by line."""
    lines = []
    for name in ("heading", "list", "detail", "status"):
        pane = app.screen.query_one(f"#{name}", LinesPane)
        lines += [pane.render_line(y).text.rstrip() for y in range(pane.size.height)]
    return lines


def picture_of(app: ViewApp) -> str:
    """The screen as SVG, without the fonts that textual would have a browser fetch."""
    drawn = app.export_screenshot(title="rosbase view")
    return re.sub(r"@font-face \{.*?\}\s*", "", drawn, flags=re.S) + MADE_WITH


def test_the_source_is_started_and_closed() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        assert stage.source.calls == ["start"]
        await pilot.press("q")

    stage.play(play)
    assert stage.source.calls == ["start", "close"]


def test_the_screen_shows_topics_and_the_message_of_the_first() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        shown = text_of(app)
        assert any("/imu/data" in line and "200.0 Hz" in line for line in shown)
        assert any("yaw   30.0" in line for line in shown)
        assert stage.source.gazes == [Gaze(topics=frozenset({IMU_TOPIC}))]

    stage.play(play)


def test_keys_choose_rows_and_pages() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("down", "down", "up")
        assert app.view.chosen == ("/joint_00/state", PID)
        await pilot.press("end")
        assert app.view.chosen == ("/joint_03/state", PID)
        await pilot.press("tab")
        assert app.view.number == 1
        await pilot.press("shift+tab", "shift+tab")
        assert app.view.number == 5
        await pilot.press("4")
        assert app.view.number == 3

    stage.play(play)


def test_a_key_drives_the_lifecycle() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2", "a")
        assert stage.source.changes == [ChangeState(ARM, "activate")]

    stage.play(play)


def test_keys_that_come_together_meet_the_row_that_they_chose() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2")
        for key in ("down", "up", "a", "down", "s"):
            event = Key(key, key if len(key) == 1 else None)
            event.set_sender(app)
            app.post_message(event)
        await until(pilot, lambda: app.view.chosen == ROBOT)
        assert stage.source.changes == [ChangeState(ARM, "activate")]

    stage.play(play)


def test_a_parameter_is_edited() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2", "enter", "enter")
        await pilot.pause()
        assert isinstance(app.screen, ValueEditor)
        assert app.screen.query_one(Input).value == "1.5"
        # None of these is a key of the view now.
        await pilot.press("end", "q", "2", "enter")
        await pilot.pause()
        assert stage.source.changes == [SetParameter(ARM, "speed", "1.5q2")]

    stage.play(play)


def test_keys_that_come_together_keep_their_order() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2", "enter", "enter")
        await pilot.pause()
        for key in ("left", "backspace", "2", "right", "backspace", "7", "enter"):
            event = Key(key, key if len(key) == 1 else None)
            event.set_sender(app)
            app.post_message(event)
        await until(pilot, lambda: bool(stage.source.changes))
        assert stage.source.changes == [SetParameter(ARM, "speed", "127")]

    stage.play(play)


def test_ctrl_c_ends_the_view_also_from_the_editor() -> None:
    for is_editing in (False, True):
        stage = Stage()

        async def play(app: ViewApp, pilot: "Pilot[None]", is_editing: bool = is_editing) -> None:
            if is_editing:
                app.push_screen(ValueEditor("speed", "1.5"))
                await pilot.pause()
            await pilot.press("ctrl+c")
            await until(pilot, lambda: not app.is_running)

        stage.play(play)
        assert stage.app.return_code == 0
        assert stage.source.calls[-1] == "close"


def test_an_edit_is_given_up() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2", "enter", "enter")
        await pilot.pause()
        await pilot.press("9", "escape")
        await pilot.pause()
        assert not isinstance(app.screen, ValueEditor)
        assert stage.source.changes == []

    stage.play(play)


def test_the_view_goes_on_behind_the_editor() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2", "enter", "enter")
        await pilot.pause()
        before = app.view.known.topics[IMU_TOPIC].total
        stage.source.waiting = [Counted(IMU_TOPIC, 5, 0.1)]
        await stage.step(pilot)
        assert app.view.known.topics[IMU_TOPIC].total == before + 5

    stage.play(play)


def test_a_recording_is_not_changed() -> None:
    stage = Stage()
    stage.source.can_change = False

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press("2", "a")
        assert stage.source.changes == []
        await stage.step(pilot)
        assert "a recording cannot be changed" in text_of(app)

    stage.play(play)


def test_only_lines_that_have_changed_are_drawn_anew() -> None:
    stage = Stage(topics=40)

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        pane = app.screen.query_one("#list", LinesPane)
        assert pane.redraw() == 0
        app.view.known.take([Counted(IMU_TOPIC, 7, 0.5)], stage.clock.monotonic_ns())
        assert pane.redraw() == 1

    stage.play(play, LARGE)


def test_a_click_chooses_a_row() -> None:
    stage = Stage()

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.click("#list", offset=(5, 3))
        assert app.view.chosen == ("/joint_01/state", PID)

    stage.play(play)


@pytest.mark.parametrize("size", [(1, 1), (20, 5), (400, 120)], ids=["1x1", "20x5", "400x120"])
def test_any_size_of_a_terminal_will_do(size: tuple[int, int]) -> None:
    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        for page in "123456":
            await pilot.press(page)

    Stage().play(play, size)


def test_a_terminal_may_change_its_size() -> None:
    def is_beside(app: ViewApp) -> bool:
        return any("│ /imu/data" in line for line in text_of(app))

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        # textual passes a new size on after a while.
        await pilot.resize_terminal(*LARGE)
        await until(pilot, lambda: is_beside(app))
        await pilot.resize_terminal(*SMALL)
        await until(pilot, lambda: not is_beside(app))

    Stage().play(play)


def test_without_colour_nothing_is_written_in_colour(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")
    stage = Stage(ASCII)
    stage.source.waiting.append(Said("no", is_error=True))

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        assert app.no_color
        assert any(line.startswith("> /imu/data") for line in text_of(app))

    stage.play(play)


@pytest.mark.once
@both_sizes
@pytest.mark.parametrize(
    ("name", "keys"),
    [
        ("topics", ["1"]),
        ("nodes", ["2"]),
        ("parameters", ["3"]),
        ("editor", ["3", "enter"]),
        ("log", ["4"]),
        ("loop", ["5"]),
        ("programs", ["6"]),
    ],
)
def test_a_picture_of_each_page(
    name: str, keys: list[str], size: tuple[int, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TZ", "UTC")
    time.tzset()
    stage = Stage(topics=50)
    kept = PICTURES / f"{name}-{size[0]}x{size[1]}.svg"
    pictures: list[str] = []

    async def play(app: ViewApp, pilot: "Pilot[None]") -> None:
        await pilot.press(*keys)
        # The list gets its rows only after the page was turned.
        await stage.step(pilot)
        pictures.append(picture_of(app))

    stage.play(play, size)
    if os.environ.get(UPDATE):
        kept.parent.mkdir(exist_ok=True)
        kept.write_text(pictures[0])
    before = kept.read_text()
    if MADE_WITH not in before:
        pytest.skip("another version writes the same screen in another way; nox has the right one")
    assert pictures[0] == before, f"if it should look so, set {UPDATE}=1 and run again"


def test_the_pictures_are_made_with_the_versions_that_nox_installs() -> None:
    noxfile = (ROOT / "noxfile.py").read_text()
    textual, rich = (re.findall(rf'"{name}==([\d.]+)"', noxfile)[0] for name in ("textual", "rich"))
    for picture in PICTURES.glob("*.svg"):
        assert f"<!-- textual {textual}, rich {rich} -->" in picture.read_text(), picture.name
