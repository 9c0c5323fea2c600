"""Signals end code that blocks on ROS as they do without it (see tests/core/test_signals.py)."""

import signal
from pathlib import Path

import pytest

from support.blocking_program import BLOCKING_PROGRAM
from support.program import running

PROGRAM = f"""
import warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
{BLOCKING_PROGRAM}
"""
PLACES = ["handle", "handshake", "callback", "on_configure", "spin in handle", "native in handle"]


@pytest.fixture(autouse=True)
def on_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("place", PLACES)
def test_a_signal_ends_code_that_blocks_and_the_whole_clean_up_runs(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, PROGRAM, place) as program:
        program.read_until("blocking")
        took_s, status, out, err = program.stop(signum)
    assert (status, err.count("Traceback")) == (0, 0), err
    assert out.splitlines()[-3:] == ["arm shut down", "released", "returned"]
    assert took_s < (20.0 if place.startswith("native") else 5.0)


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("place", ["constructor", "own constructor"])
def test_a_signal_in_a_constructor_undoes_it_and_ends_quietly(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, PROGRAM, place) as program:
        program.read_until("blocking")
        _, status, _, err = program.stop(signum)
    assert (status, err) == (0, "")
