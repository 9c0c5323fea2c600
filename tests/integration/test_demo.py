"""`rosbase demo`: the first thing that a newcomer runs."""

import re
import signal

import pytest

from support.command import ROSBASE, RunningRosbase, run_rosbase, summary_of
from support.terminal import on_terminal


@pytest.mark.parametrize(("rate", "at_least"), [(None, 490), (1000, 4950)])
def test_the_demo_publishes_every_sample(rate: int | None, at_least: int) -> None:
    more = [] if rate is None else ["--rate", str(rate)]
    done = run_rosbase("demo", "--duration", "5", "--no-unplug", *more)
    assert done.returncode == 0, done.stderr
    counts = summary_of(done.stdout.splitlines())
    assert counts["published"] >= at_least
    assert counts["sent"] == counts["received"] == counts["published"]
    assert (counts["lost"], counts["rejected"], counts["dropped"]) == (0, 0, 0)
    assert 0 < counts["latency_p50_ms"] <= counts["latency_p99_ms"] < 1000
    assert "\x1b" not in done.stdout + done.stderr
    assert "\r" not in done.stdout
    assert done.stdout.count(" Hz ") >= 4, "a plain line each second"


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_a_demo_that_is_stopped_early_has_lost_nothing(signum: int) -> None:
    with RunningRosbase("demo", "--duration", "60") as demo:
        demo.waits_for("published", where=demo.out)
        assert demo.end(signum) == 0
    counts = summary_of(demo.out.lines)
    assert counts["sent"] == counts["published"] > 50
    assert counts["lost"] == 0
    assert "Traceback" not in demo.err


def test_by_default_the_plug_is_pulled_once_and_nothing_is_lost() -> None:
    done = run_rosbase("demo", "--duration", "4")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    counts = summary_of(lines)
    assert counts["sent"] == counts["received"] == counts["published"]
    assert (counts["lost"], counts["reconnects"]) == (0, 1)
    # 4 s at 100 Hz, less 0.8 s without a plug and the time to open it again.
    assert 150 < counts["sent"] < 325
    number = counts["sent"]
    verdict = f"All {number:.0f} samples that the device sent were published, although it was"
    assert any(line.startswith(verdict) for line in lines)
    assert lines[-1].startswith("Try next: rosbase simulate")
    assert "was lost" in done.stderr
    assert "is back" in done.stderr


def test_a_demo_that_is_stopped_while_the_plug_is_out_ends_at_once() -> None:
    with RunningRosbase("demo", "--duration", "5") as demo:
        demo.waits_for("was lost")
        assert demo.end(signal.SIGINT) == 0
    assert "the device was not plugged in again before the end" in demo.out


AXIS = r"[xyz] +[+-]\d+\.\d\d [ █▌▐]+│[ █▌▐]+ +[+-]\d+\.\d\d [ █▌▐]+│[ █▌▐]*"
PANEL = [
    r"rosbase demo   \d+\.\d s of 4 s   /.*/ttyIMU",
    r"rate \d+\.\d Hz   latency \d+\.\d\d ms   lost 0   published \d+( .*\d)?",
    r"roll +[+-]\d+\.\d°   pitch +[+-]\d+\.\d°   yaw +[+-]\d+\.\d°",
    r"  acceleration, m/s² ±20 +angular velocity, rad/s ±2",
    *[AXIS] * 3,
    r"(OK: samples arrive|unplugged .*|plugged in .*|WARN: .*|ERROR: .*)",
]


@pytest.mark.parametrize(
    ("columns", "has_colour"), [(60, True), (60, False), (80, True), (100, False), (160, True)]
)
def test_on_a_terminal_a_panel_of_whole_fields_fits_the_width(
    columns: int, *, has_colour: bool
) -> None:
    environment = {"TERM": "xterm", "NO_COLOR": "" if has_colour else "1"}
    with on_terminal(
        ROSBASE, "demo", "--duration", "4", columns=columns, environment=environment
    ) as demo:
        screens = demo.screens(until="Try next")
        assert demo.process.wait(20) == 0
    panels = [panel for panel in map(panel_in, screens) if panel]
    assert len(panels) > 5
    for panel in panels:
        for line, pattern in zip(panel, PANEL, strict=True):
            assert re.fullmatch(pattern, line), (pattern, line)
    notes = " ".join(panel[-1] for panel in panels)
    assert "OK: samples arrive" in notes
    assert "unplugged" in notes
    assert "plugged in again: back after" in notes
    assert (b"\x1b[1m" in demo.shown) == has_colour


def panel_in(screen: list[str]) -> list[str]:
    """The last panel on a screen, if there is one."""
    begins = [number for number, line in enumerate(screen) if line.startswith("rosbase demo")]
    return screen[begins[-1] :][: len(PANEL)] if begins else []


def test_a_terminal_that_is_too_small_has_one_line() -> None:
    with on_terminal(ROSBASE, "demo", "--duration", "1", columns=40) as demo:
        screens = demo.screens(until="Try next")
        assert demo.process.wait(20) == 0
    assert any(re.fullmatch(r"OK: samples arrive   rate \d+\.\d Hz", line) for line in screens[1])
    assert not any(line.startswith("rosbase demo") for screen in screens for line in screen)
