"""Commands that look at the examples and the IMU reader and operate them, as the page shows it."""

import os
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import pytest

from rosbase.cli.arguments import check_given, read_given
from rosbase.imu.settings import reader_parameters
from rosbase.plugins import installed_plugins
from support.code_blocks import ROOT, blocks_of
from support.command import RunningRosbase
from support.operated import Robots, robots_in, run, wait_for_programs
from support.waiting import wait_until

PAGE = "docs/how-to/operate.md"


@pytest.fixture
def robots(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robots]:
    with robots_in(tmp_path, monkeypatch) as found:
        yield found


def commands_of(word: str) -> list[list[str]]:
    """The commands of the block on the page that has this word."""
    (block,) = [b for b in blocks_of(PAGE, "bash") if word in b.text and "rosbase" in b.text]
    return [shlex.split(line)[1:] for line in block.text.splitlines()]


def example(robots: Robots, name: str, program: str) -> "subprocess.Popen[str]":
    """Starts an example, and waits until its main loop runs."""
    process = robots.start_process([sys.executable, "-W", "error", f"docs/examples/{name}"], ROOT)
    wait_for_programs(program)
    wait_until(lambda: "running: " in run("ps"), "the main loop")
    return process


def shown_by(robots: Robots, words: list[str]) -> str:
    """What a command of the page prints; Ctrl-C ends one that goes on."""
    if words[:2] != ["topic", "hz"]:
        return run(*words)
    command = robots.start_command(*words)
    assert command.stdout is not None
    lines = list(islice(command.stdout, 2))
    command.send_signal(signal.SIGINT)
    command.communicate(timeout=20)
    return "".join(lines)


def test_the_quadruped_is_looked_at_as_on_the_page(robots: Robots) -> None:
    process = example(robots, "quadruped", "Quadruped")
    shown = {" ".join(words): shown_by(robots, words) for words in commands_of("topic hz")}
    ps, topics, info, imu, rate, stats = shown.values()
    assert re.search(r"Quadruped  manager  local +running: \w+ +50 Hz", ps)
    assert "/cmd_vel [geometry_msgs/msg/Twist]\n" in topics
    assert "Publisher count: 1\nSubscription count: 1\n" in info
    assert re.fullmatch(r"x: \S+\ny: \S+\nz: \S+\nw: \S+\n---\n", imu)
    assert rate.startswith("average rate: ")
    assert " ticks at 50 Hz, " in stats
    process.send_signal(signal.SIGINT)
    assert process.communicate(timeout=20)[1] == ""
    assert process.returncode == 0


def test_the_stop_of_the_quadruped_is_pressed_as_on_the_page(robots: Robots) -> None:
    (words,) = commands_of("topic pub")
    command = robots.start_command(*words)
    assert command.stdout is not None
    assert command.stdout.readline().startswith("Waiting for ")
    process = robots.start_process([sys.executable, "-W", "error", "docs/examples/quadruped"], ROOT)
    shown, told = command.communicate(timeout=30)
    # The stop ends the program, perhaps before the last message.
    assert (command.returncode, told) in (
        (0, ""),
        (1, f"rosbase: process {process.pid} has ended\n"),
    )
    out, err = process.communicate(timeout=20)
    assert err == ""
    assert out.endswith("-> emergency [wants_stop]\n")
    # Without it, the robot falls, gets up and arrives before.
    assert "recovery" not in out
    assert "publishing #1: sensor_msgs.msg.Joy(header=std_msgs.msg.Header(" in shown


def test_pick_and_place_is_looked_at_and_stopped(robots: Robots) -> None:
    process = example(robots, "pick_place", "PickPlaceOrchestrator")
    assert run("node", "list") == "/PickPlaceOrchestrator\n"
    assert "    /gripper: std_msgs/msg/Bool\n" in run("node", "info", "PickPlaceOrchestrator")
    one = run("topic", "echo", "/joint_states", "--once")
    assert one.startswith("header:\n  stamp:\n    sec: ")
    assert "name:\n- " in one
    assert run("param", "list") == "/PickPlaceOrchestrator:\n"
    assert run("lifecycle", "nodes") == ""
    assert int(run("service", "list", "-c")) == 6
    run("stop", "PickPlaceOrchestrator")
    assert process.communicate(timeout=20)[1] == ""
    assert process.returncode == 0


def test_the_imu_reader_is_operated_as_on_the_page(robots: Robots, tmp_path: Path) -> None:
    with RunningRosbase("simulate") as device:
        device.waits_for("rosbase imu", where=device.out)
        line = next(line for line in device.out.lines if "rosbase imu" in line)
        with RunningRosbase(*shlex.split(line)[1:]) as reader:
            wait_for_programs("lifecycle_manager", "simulate")
            wait_until(lambda: "active [3]" in run("lifecycle", "get"), "the reader")
            echo = run("topic", "echo", "imu/data", "--once")
            assert echo.count("\n- ") == 27
            hz = shown_by(robots, ["topic", "hz", "imu/data"])
            assert 80.0 < float(hz.split()[2]) < 120.0
            state, names, described, was_set, dump, offered, log, stopped = (
                run(*words) for words in commands_of("lifecycle list")
            )
            assert state == "active [3]\n"
            assert "  frame_id\n" in names
            assert described.startswith("Parameter name: frame_id\n  Type: string\n")
            assert was_set == "Set parameter successful\n"
            assert "    frame_id: left_imu\n" in dump
            saved = tmp_path / "imu.yaml"
            saved.write_text(dump)
            specs = reader_parameters(installed_plugins())
            again = check_given(specs, read_given([], saved))
            assert again["frame_id"] == "left_imu"
            assert offered.startswith("- deactivate [4]\n\tStart: active\n\tGoal: deactivating\n")
            assert "health OK" in log
            assert stopped.startswith("stopped lifecycle_manager [")
            assert reader.end() == 0


def test_a_reader_goes_through_its_states_and_goes_on(robots: Robots) -> None:
    with RunningRosbase("simulate") as device:
        device.waits_for("rosbase imu", where=device.out)
        line = next(line for line in device.out.lines if "rosbase imu" in line)
        with RunningRosbase(*shlex.split(line)[1:]) as reader:
            wait_for_programs("lifecycle_manager")
            wait_until(lambda: "active [3]" in run("lifecycle", "get"), "the reader")
            for transition in ("deactivate", "cleanup", "configure", "activate"):
                run("lifecycle", "set", "lifecycle_manager", transition)
            assert "  frame_id: " in run("topic", "echo", "imu/data", "--once")
            run("stop", "lifecycle_manager")
            assert reader.end() == 0


def test_a_reader_that_others_bring_up_is_brought_up(robots: Robots) -> None:
    with RunningRosbase("simulate") as device:
        device.waits_for("rosbase imu", where=device.out)
        line = next(line for line in device.out.lines if "rosbase imu" in line)
        with RunningRosbase(*shlex.split(line)[1:], "--managed") as reader:
            wait_for_programs("lifecycle_manager")
            for transition in ("configure", "activate"):
                assert run("lifecycle", "set", "lifecycle_manager", transition).endswith(
                    "successful\n"
                )
            assert "  frame_id: " in run("topic", "echo", "imu/data", "--once")
            run("param", "set", "lifecycle_manager", "frame_id", "left")
            err = run("param", "set", "lifecycle_manager", "stale_timeout", "2.5", status=1)
            assert "cannot be set while active" in err
            run("lifecycle", "set", "lifecycle_manager", "deactivate")
            assert run("lifecycle", "get") == "/lifecycle_manager: inactive [2]\n"
            run("stop", "lifecycle_manager")
            assert reader.end() == 0


def test_the_first_lines_of_a_table_are_wide_enough_for_pids(robots: Robots) -> None:
    process = example(robots, "pick_place", "PickPlaceOrchestrator")
    head, row = run("ps").splitlines()
    assert head.index("PROGRAM") == row.index("PickPlace")
    os.kill(process.pid, signal.SIGINT)
    process.communicate(timeout=20)
