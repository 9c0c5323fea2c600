"""`rosbase view --web` as a user has it: the command, a program with a board, and Chromium."""

import contextlib
import fcntl
import io
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import pytest
from attrs import evolve
from PIL import Image

from rosbase import SystemClock
from rosbase.control import connect
from rosbase_view.reports import Position, Survey
from rosbase_view.source import Gaze
from rosbase_view.web.address import page_url
from rosbase_view.web.page import Page
from rosbase_view.web.server import bind
from support.browser import Browser, browser, chromium
from support.command import RunningRosbase
from support.operated import Robots, robots_in
from support.program import Program
from support.viewing import (
    IMU_TOPIC,
    PID,
    SECOND,
    MadePlayback,
    MadeSource,
    imu_heard,
    made_process,
    made_topic,
    reports,
)
from support.waiting import wait_until

# The machine that tests for all must not leave them out.
IS_REQUIRED = os.environ.get("NEEDS_CHROMIUM") == "1"
pytestmark = [
    pytest.mark.once,
    # A test waits for those before it.
    pytest.mark.timeout(400),
    pytest.mark.skipif(not (chromium() or IS_REQUIRED), reason="Chromium is not installed"),
]

Pixels: TypeAlias = npt.NDArray[np.int16]

TOKEN = "secret-secret-16"
BOARD = """
import sys

from rosbase import BaseHandlers, BaseManager, LifecycleNode
from rosbase.messages import (
    DiagnosticArray, DiagnosticStatus, Header, Imu, Quaternion, Time, Vector3,
)
from rosbase.utils import rpy_to_quat


class Board(LifecycleNode):
    autostart = "activate"

    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        for name in ("roll", "pitch", "yaw"):
            self.declare_parameter(name, 0.0)
        self.imu = self.create_publisher(Imu, sys.argv[1] + "/data")
        self.health = self.create_publisher(DiagnosticArray, "/diagnostics")

    def send(self):
        angles = (self.get_parameter(name).value for name in ("roll", "pitch", "yaw"))
        x, y, z, w = rpy_to_quat(*angles, order="xyzw")
        header = Header(self.get_clock().now(), "imu_link")
        self.imu.publish(
            Imu(header, Quaternion(x, y, z, w), linear_acceleration=Vector3(0.0, 0.0, 9.80665))
        )
        status = DiagnosticStatus(level=1, name="desk: IMU", message="the <b>cable</b> is loose")
        self.health.publish(DiagnosticArray(header, (status,)))


class Handlers(BaseHandlers):
    def handle(self):
        self.node(Board).send()
        if self.timestamp == 5:
            print("ready", flush=True)


manager = BaseManager("desk", {"board": Board}, {}, Handlers, node_freq_hz=50)
manager.start_main_loop_timer()
"""
"""A manager with a board that is turned as its parameters say."""


@pytest.fixture(autouse=True)
def alone() -> Iterator[None]:
    """One of these tests runs at a time: a browser that draws by software takes all processors."""
    path = Path(tempfile.gettempdir(), "rosbase-tests-browser")
    with path.open("w") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


@contextlib.contextmanager
def viewed(*words: str) -> Iterator[tuple[RunningRosbase, str]]:
    """Runs the view; gives it and the address that it prints."""
    with RunningRosbase("view", "--web", "0", *words) as view:
        view.waits_for("(Ctrl-C to end)", where=view.out)
        yield view, view.out.lines[0].split()[3]


def start(robots: Robots, namespace: str = "imu") -> Program:
    return robots.start(BOARD, namespace)


def turn(roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> None:
    """Turns the board, in radians."""
    connect("desk").set_parameters("board", {"roll": roll, "pitch": pitch, "yaw": yaw})


def picture(page: Browser, shows: Callable[[Pixels], object]) -> Pixels:
    """What is left of the panel, as soon as it shows that.

    The page draws a frame some time after it has got a message, and coarser ones under load.
    """
    # A notice that WebGL draws by software.
    page.hide("[class*=Notification]")
    taken: list[Pixels] = []

    def is_seen() -> bool:
        image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        taken[:] = [np.asarray(image, dtype=np.int16)[:, :450]]
        return bool(shows(taken[0]))

    wait_until(is_seen, "a picture of the board as it is turned", 80.0)
    return taken[0]


def changed(one: Pixels, other: Pixels) -> float:
    """The share of pixels that differ visibly."""
    return float((np.abs(one - other).max(axis=2) > 30).mean())


def rows_of(seen: Pixels, colour: int) -> Any:
    """The rows of the pixels that have mostly one colour: 0 is red, 1 green."""
    others = np.delete(seen, colour, axis=2).max(axis=2)
    return np.nonzero(seen[:, :, colour] - others > 40)[0]


def test_the_board_turns_in_the_browser(robots: Robots, tmp_path: Path) -> None:
    start(robots)
    with viewed() as (_, url), browser(tmp_path) as page:
        page.open(url)
        page.until("roll 0.0°, pitch 0.0°, yaw 0.0°")
        # Grey until its orientation is known.
        level = picture(page, lambda seen: len(rows_of(seen, 1)) > 4_000)
        turn(roll=np.pi / 2)
        page.until("roll 90.0°")
        # It stands, so it is higher than before.
        height = 1.2 * np.ptp(rows_of(level, 1))
        on_edge = picture(page, lambda seen: np.ptp(rows_of(seen, 1)) > height)
        assert changed(level, on_edge) > 0.05
        # REP-103: a positive pitch turns the front, which is the red axis, down.
        middle = rows_of(level, 0).mean()
        turn(pitch=0.6)
        page.until("pitch 34.4°")
        picture(page, lambda seen: rows_of(seen, 0).mean() > middle + 3)
        turn(pitch=-0.6)
        page.until("pitch -34.4°")
        picture(page, lambda seen: rows_of(seen, 0).mean() < middle - 3)


def test_the_page_shows_health_curves_and_the_buttons_of_legal_transitions(
    robots: Robots, tmp_path: Path
) -> None:
    program = start(robots)
    with viewed("desk") as (view, url), browser(tmp_path) as page:
        page.open(url)
        page.until("WARN desk: IMU: the <b>cable</b> is loose")
        page.until("orientation, °", "angular velocity, rad/s", "acceleration, m/s²")
        assert "magnetic field" not in page.text
        page.until_true("document.querySelectorAll('.uplot canvas').length >= 3", "the plots")
        page.until_buttons("deactivate", "shutdown")
        page.press("deactivate")
        # The notice stays for ten seconds, in which a busy machine draws the page only some times.
        page.until("/board is inactive")
        page.until_buttons("activate", "cleanup", "shutdown")
        assert view.end(signal.SIGINT) == 0
        assert view.err.lines == []
        assert len(view.out.lines) == 1
    assert program.process.poll() is None


def test_a_program_that_goes_and_comes_back_is_shown_again(
    robots: Robots, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_VIEW_TOKEN", TOKEN)
    first = start(robots)
    with viewed() as (view, url), browser(tmp_path) as page:
        assert url.endswith(f"/{TOKEN}/")
        page.open(url)
        page.until("roll 0.0°")
        first.process.send_signal(signal.SIGINT)
        page.until("nobody publishes it now", "/imu/data (gone)")
        page.until_buttons()
        start(robots)
        page.until("roll 0.0°")
        page.until_buttons("deactivate", "shutdown")
        assert view.err.lines == []


def test_a_view_that_is_gone_is_told_and_found_again(tmp_path: Path) -> None:
    lost = "No connection to rosbase view"
    with browser(tmp_path) as page:
        with served(boards()) as url:
            page.open(url)
            page.until("/arm/imu")
            assert lost not in page.text
        page.until(lost)
        with served(boards(("/leg/imu", PID)), int(url.split(":")[2].partition("/")[0])):
            page.until("/leg/imu")
            assert lost not in page.text


def boards(*keys: tuple[str, int]) -> MadeSource:
    """A source with these boards."""
    source = MadeSource()
    topics = {key: made_topic(key[0]) for key in keys or [("/arm/imu", PID)]}
    source.waiting = [Survey([made_process()], topics, [], [])]
    return source


def test_two_browsers_show_the_same_and_without_any_the_view_asks_for_nothing(
    tmp_path: Path,
) -> None:
    arm = ("/arm/imu", PID)
    topics = {key: made_topic(key[0]) for key in (IMU_TOPIC, arm)}
    source = MadeSource()
    source.waiting = [Survey([made_process()], topics, [], [])]
    with served(source) as url:
        with browser(tmp_path / "one") as one, browser(tmp_path / "other") as other:
            assert source.gazes == []
            one.open(url)
            one.until("/arm/imu")
            other.open(url)
            other.until("/arm/imu")
            wait_until(lambda: source.gazes == [Gaze(topics=frozenset({arm}))], "a look")
            one.choose("/arm/imu", "/imu/data")
            other.until_true(
                "![...document.querySelectorAll('input')].some(one => one.value === '/arm/imu')",
                "the choice in the other browser",
            )
            wait_until(lambda: source.gazes[-1].topics == {IMU_TOPIC}, "a look at the other")
        wait_until(lambda: source.gazes[-1] == Gaze(), "an end of looking")
    assert source.calls == ["start", "close"]


def test_a_recording_is_played_and_its_nodes_are_not_changed(tmp_path: Path) -> None:
    source, playback = MadeSource(can_change=False), MadePlayback()
    source.playback = playback
    source.waiting = [
        *reports(),
        evolve(imu_heard(90.0), stamp_ns=SECOND),
        Position(SECOND, 0, 10 * SECOND, is_playing=False),
    ]
    with served(source) as url, browser(tmp_path) as page:
        page.open(url)
        page.until("yaw 90.0°", "seconds", "inactive")
        page.until_buttons("play")
        # It has begun when the page was opened, and the made position stays.
        wait_until(lambda: playback.calls == [("play",)], "the beginning")
        page.press("play")
        wait_until(lambda: playback.calls == [("play",)] * 2, "the press")


@contextlib.contextmanager
def served(source: MadeSource, port: int = 0) -> Iterator[str]:
    """Runs the page of a source on a thread; gives its address."""
    listening = bind("127.0.0.1", port)
    url = page_url("127.0.0.1", listening.getsockname()[1], TOKEN, "")
    page = Page(source, listening, TOKEN, SystemClock())
    thread = threading.Thread(target=page.run)
    thread.start()
    try:
        yield url
    finally:
        page.end()
        thread.join()
