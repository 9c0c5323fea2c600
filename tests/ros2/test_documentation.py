"""What the documentation shows of ROS 2, run; and what it says to systemd and nav2."""

import configparser
import shlex
import signal
from pathlib import Path
from typing import Any

import pytest
import yaml
from lifecycle_msgs.msg import Transition

from support.code_blocks import BLOCKS, DEVICE, ROOT, Block, blocks_of, write_files
from support.code_runs import run_commands, run_python, sending
from support.command import RunningRosbase
from support.ros import Client

SYSTEMD, NAV2 = "docs/how-to/systemd.md", "docs/how-to/nav2.md"


def for_ros(kind: str) -> list[str]:
    """The blocks to be run on ROS; the reader for nav2 waits for its manager, below."""
    found = (name for name, block in BLOCKS.items() if block.kind == kind and block.is_for_ros)
    return [name for name in found if not name.startswith(NAV2)]


def unit(block: Block) -> configparser.SectionProxy:
    """What systemd runs."""
    parser = configparser.ConfigParser(interpolation=None, strict=True)
    # As configparser's documentation has it.
    parser.optionxform = str  # type: ignore[assignment,method-assign]  # as its documentation has it
    parser.read_string(block.text)
    return parser["Service"]


@pytest.mark.parametrize("name", for_ros("python"))
def test_python_runs_on_ros(name: str, tmp_path: Path) -> None:
    run_python(BLOCKS[name], tmp_path)


@pytest.mark.parametrize("name", for_ros("bash"))
def test_commands_run_on_ros(name: str, tmp_path: Path) -> None:
    run_commands(BLOCKS[name], tmp_path)


@pytest.mark.parametrize("number", [0, 1])
def test_what_the_unit_starts_reads_the_device_and_ends_well_when_it_is_stopped(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    service = unit(blocks_of(SYSTEMD, "ini")[number])
    for assignment in service["Environment"].split():
        name, _, value = assignment.partition("=")
        # The folder that systemd would make.
        monkeypatch.setenv(name, str(tmp_path) if value.startswith("/var/log/") else value)
    program, *arguments = shlex.split(service["ExecStart"].replace("%i", "left"))
    assert program.endswith("/bin/rosbase")
    (file,) = [word for word in arguments if word.endswith(".toml")]
    with sending("") as path:
        write_files(ROOT / SYSTEMD, tmp_path, path)
        given = [str(tmp_path / "imu.toml") if word == file else word for word in arguments]
        with RunningRosbase(*given) as reader:
            reader.waits_for(f"opened {path}")
            assert reader.end(signal.SIGTERM) == 0
        assert reader.out.lines == []


def test_the_unit_keeps_its_log_where_it_may_write() -> None:
    for block in blocks_of(SYSTEMD, "ini"):
        service = unit(block)
        assert f"ROS_LOG_DIR=/var/log/{service['LogsDirectory']}" in service["Environment"]


def test_the_reader_goes_along_with_what_nav2s_manager_asks_for(context: Any) -> None:
    (parameters,) = (yaml.safe_load(block.text) for block in blocks_of(NAV2, "yaml"))
    manager = parameters["lifecycle_manager_sensors"]["ros__parameters"]
    assert (manager["bond_timeout"], manager["autostart"]) == (0.0, True)
    (name,) = manager["node_names"]
    start, ask = (block.text for block in blocks_of(NAV2, "bash"))
    assert "__node:=lifecycle_manager_sensors" in ask
    client = Client(context, name)
    with sending("") as path:
        arguments = shlex.split(start.replace(DEVICE, path))[1:]
        with RunningRosbase(*arguments) as reader:
            client.await_services()
            # By number alone, up, and down again; and the state is asked for after each.
            for number, goal in (
                (Transition.TRANSITION_CONFIGURE, "inactive"),
                (Transition.TRANSITION_ACTIVATE, "active"),
                (Transition.TRANSITION_DEACTIVATE, "inactive"),
                (Transition.TRANSITION_CLEANUP, "unconfigured"),
                (Transition.TRANSITION_UNCONFIGURED_SHUTDOWN, "finalized"),
            ):
                assert client.change(number)
                assert client.state() == goal
            assert reader.end(signal.SIGINT) == 0
    client.destroy()
