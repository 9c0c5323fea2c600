"""Signals end code that blocks on ROS as they do without it (see tests/core/test_signals.py)."""

import signal
from pathlib import Path

import pytest

from support.blocking_program import (
    BLOCKING_PROGRAM,
    expect_a_clean_end,
    expect_a_named_thread,
    expect_the_end_of_an_input,
)
from support.program import running

WITH_RCLPY = BLOCKING_PROGRAM.replace(
    """    elif PLACE.startswith("loop"):
""",
    """    elif PLACE.startswith("future"):
        rclpy.spin_until_future_complete(manager.backend.node, rclpy.Future())
    elif PLACE.startswith("rclpy"):
        rclpy.spin(manager.backend.node)
    elif PLACE.startswith("loop"):
""",
)
assert WITH_RCLPY != BLOCKING_PROGRAM
PROGRAM = f"""
import warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
import rclpy
{WITH_RCLPY}
"""
SIGNALS = [signal.SIGINT, signal.SIGTERM]
PLACES = [
    *("handle", "handshake", "callback", "on_configure"),
    *("loop in handle", "spin in handle", "native in handle"),
    *("loop in handshake", "spin in handshake"),
    *("future in handle", "rclpy in handle", "future in handshake", "future in callback"),
]


@pytest.fixture(autouse=True)
def on_ros(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")


@pytest.mark.parametrize("signum", SIGNALS)
@pytest.mark.parametrize("place", PLACES)
def test_a_signal_ends_code_that_blocks_and_the_whole_clean_up_runs(
    place: str, signum: int, tmp_path: Path
) -> None:
    expect_a_clean_end(tmp_path, PROGRAM, place, signum)


@pytest.mark.parametrize("signum", SIGNALS)
def test_a_signal_ends_an_input_on_a_terminal(signum: int, tmp_path: Path) -> None:
    expect_the_end_of_an_input(tmp_path, PROGRAM, signum)


@pytest.mark.parametrize("signum", SIGNALS)
def test_a_thread_that_never_ends_is_named_and_the_manager_returns(
    signum: int, tmp_path: Path
) -> None:
    expect_a_named_thread(tmp_path, PROGRAM, signum)


@pytest.mark.parametrize("signum", SIGNALS)
@pytest.mark.parametrize("place", ["constructor", "own constructor"])
def test_a_signal_in_a_constructor_undoes_it_and_ends_quietly(
    place: str, signum: int, tmp_path: Path
) -> None:
    with running(tmp_path, PROGRAM, place) as program:
        program.read_until("blocking")
        _, status, _, err = program.stop(signum)
    assert (status, err) == (0, "")
