"""The examples, run as a newcomer runs them. They need rosbase-core and nothing else."""

import ast
import os
import re
import signal
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import pytest

from support.command import Lines
from support.waiting import wait_until

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "docs/examples"

PICK_PLACE = """
    WAIT_FOR_PICK_TARGET ROTATE_TO_PICK APPROACH_PICK AI_CONFIRM_PICK
    ROTATE_TO_PICK APPROACH_PICK AI_CONFIRM_PICK GRASP_EXECUTION
    ROTATE_TO_PICK APPROACH_PICK AI_CONFIRM_PICK GRASP_EXECUTION
    WAIT_FOR_PLACE_TARGET ROTATE_TO_PLACE AI_CONFIRM_PLACE
    ROTATE_TO_PLACE AI_CONFIRM_PLACE RELEASE_EXECUTION FINISHED
"""
QUADRUPED = """
    cold_start human_teleop turn navigation recovery turn navigation human_teleop emergency
"""
PRESSED_BETWEEN_OTHERS = """
import sys
sys.path.insert(0, "docs/examples/quadruped")
from bridge import Bridge
from rosbase.messages import Joy
bridge = Bridge()
for pressed in (0, 1, 0):
    bridge.on_joy(Joy(axes=(0.0, 0.0), buttons=(0, pressed)))
print(bridge.is_stopped)
"""
STATES = {"pick_place": PICK_PLACE.split(), "quadruped": QUADRUPED.split()}


def start(name: str, *arguments: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-W", "error", f"docs/examples/{name}", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
    )


def run(name: str, *arguments: str) -> str:
    """What it prints; it must end by itself, with status 0 and nothing to complain about."""
    with start(name, *arguments) as process:
        try:
            out, err = process.communicate(timeout=40)
        finally:
            process.kill()
    assert (process.returncode, err) == (0, "")
    return out


def block(name: str, kind: str) -> str:
    """The README's only block of that kind."""
    page = (EXAMPLES / name / "README.md").read_text()
    (text,) = re.findall(rf"```{kind}\n(.*?)```", page, re.S)
    return str(text)


def test_each_example_is_tested_here() -> None:
    programs = {page.parent.name for page in EXAMPLES.glob("*/__main__.py")}
    # The others are plugins, which bring tests of their own.
    plugins = {page.parents[1].name for page in EXAMPLES.glob("*/tests/test_contract.py")}
    assert programs == set(STATES)
    assert programs | plugins == {path.name for path in EXAMPLES.iterdir() if path.is_dir()}


@pytest.mark.parametrize("name", STATES)
def test_an_example_walks_through_its_states_and_ends_by_itself(name: str) -> None:
    out = run(name)
    moves = [tuple(line.split()[:3:2]) for line in out.splitlines()]
    assert moves == list(pairwise(STATES[name]))
    assert out == block(name, "text"), "the README shows what is printed"


@pytest.mark.parametrize("name", STATES)
def test_an_example_draws_every_state_as_its_readme_shows(name: str) -> None:
    diagram = run(name, "--diagram")
    assert diagram == block(name, "mermaid")
    drawn = set(re.findall(r"\w+(?= -->)|(?<=--> )\w+", diagram))
    assert drawn == set(STATES[name])


@pytest.mark.parametrize("name", STATES)
def test_an_example_that_is_interrupted_ends_well(name: str) -> None:
    with start(name) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        out, err = Lines(process.stdout), Lines(process.stderr)
        try:
            wait_until(lambda: len(out.lines) >= 2, f"two transitions of {name}")
            process.send_signal(signal.SIGINT)
            status = process.wait(20)
        finally:
            process.kill()
            out.join()
            err.join()
    assert (status, err.lines) == (0, [])
    assert 2 <= len(out.lines) < len(STATES[name]) - 1


@pytest.mark.parametrize("name", STATES)
def test_an_example_uses_public_names_of_the_core_only(name: str) -> None:
    own = {module.stem for module in (EXAMPLES / name).glob("*.py")}
    for module in (EXAMPLES / name).glob("*.py"):
        for node in ast.walk(ast.parse(module.read_text())):
            if isinstance(node, ast.ImportFrom):
                assert node.module in {
                    *own,
                    "argparse",
                    "collections.abc",
                    "rosbase",
                    "rosbase.fsm",
                    "rosbase.messages",
                    "typing",
                }
                assert not [alias.name for alias in node.names if alias.name.startswith("_")]
            elif isinstance(node, ast.Import):
                assert [alias.name for alias in node.names] == ["math"]


def test_a_stop_of_the_quadruped_counts_though_another_message_follows_before_the_tick() -> None:
    command = [sys.executable, "-c", PRESSED_BETWEEN_OTHERS]
    assert subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, check=True).stdout == b"True\n"
