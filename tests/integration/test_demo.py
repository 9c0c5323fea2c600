"""`rosbase demo`: the first thing that a newcomer runs."""

import os
import pty
import signal
import subprocess

import pytest

from support.command import ROSBASE, RunningRosbase, run_rosbase, summary_of


@pytest.mark.parametrize(("rate", "at_least"), [(None, 490), (1000, 4950)])
def test_the_demo_publishes_every_sample(rate: int | None, at_least: int) -> None:
    more = [] if rate is None else ["--rate", str(rate)]
    done = run_rosbase("demo", "--duration", "5", *more)
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


def test_on_a_terminal_one_line_lives() -> None:
    own_end, far_end = pty.openpty()
    with subprocess.Popen(
        [ROSBASE, "demo", "--duration", "1"], stdout=far_end, stderr=subprocess.DEVNULL
    ) as demo:
        os.close(far_end)
        shown = b""
        while True:
            try:
                shown += os.read(own_end, 4096)
            except OSError:
                # The terminal is gone: the demo has ended.
                break
        demo.wait(20)
    os.close(own_end)
    assert demo.returncode == 0
    assert shown.count(b"\r\x1b[K") >= 3
    assert b"\r\npublished 1" in shown, "the summary begins on a line of its own"
