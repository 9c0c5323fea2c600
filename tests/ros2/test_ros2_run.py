"""What `ros2 run rosbase_ros2 lifecycle_manager` finds, and what it starts."""

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import metadata
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from ament_index_python import PackageNotFoundError, get_package_prefix
from lifecycle_msgs.msg import Transition
from sensor_msgs.msg import Imu

from imu_serial.simulator import PtyDevice
from support.command import RunningRosbase
from support.ros import Client
from support.samples import GOOD_FRAME
from support.waiting import wait_until

PACKAGE = "rosbase_ros2"
EXECUTABLE = "lifecycle_manager"


@pytest.fixture
def prefix(monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the ROS tools find the package, when this environment is among their prefixes."""
    monkeypatch.setenv("AMENT_PREFIX_PATH", sys.prefix)
    try:
        return Path(get_package_prefix(PACKAGE))
    except PackageNotFoundError:
        pytest.fail(f"{sys.prefix} has not what `ros2 run` looks for: install {PACKAGE} there anew")


@pytest.fixture
def device() -> Iterator[PtyDevice]:
    device = PtyDevice()
    yield device
    device.close()


@pytest.fixture
def client(context: Any) -> Iterator[Client]:
    client = Client(context, EXECUTABLE)
    yield client
    client.destroy()


def executables(prefix: Path) -> list[Path]:
    """What `ros2 run` can start of the package, found as it does."""
    files = (prefix / "lib" / PACKAGE).rglob("*")
    return [file for file in files if file.is_file() and os.access(file, os.X_OK)]


def manifest_of(prefix: Path) -> ElementTree.Element:
    return ElementTree.parse(prefix / "share" / PACKAGE / "package.xml").getroot()


def test_ros2_run_finds_the_executable(prefix: Path) -> None:
    assert [file.name for file in executables(prefix)] == [EXECUTABLE]


def test_the_manifest_says_what_the_distribution_says(prefix: Path) -> None:
    manifest = manifest_of(prefix)
    names = ("name", "version", "description", "license")
    said = {name: manifest.findtext(name) for name in names}
    distribution = metadata("rosbase-ros2")
    assert said == {
        "name": distribution["Name"].replace("-", "_"),
        "version": distribution["Version"],
        "description": distribution["Summary"],
        "license": distribution["License-Expression"],
    }


def test_the_manifest_names_the_ros_packages_that_the_distribution_needs(prefix: Path) -> None:
    distribution = metadata("rosbase-ros2")
    required = [line for line in distribution.get_all("Requires-Dist", []) if "ros-jazzy" in line]
    packages = {re.split(r"[^\w-]", line.removeprefix("ros-jazzy-"))[0] for line in required}
    # In the package index, rclpy brings the last one.
    expected = {name.replace("-", "_") for name in packages} | {"rcl_interfaces"}
    assert {depend.text for depend in manifest_of(prefix).iter("exec_depend")} == expected


@pytest.mark.parametrize("has_python", [True, False])
def test_the_executable_takes_the_python_of_its_environment_or_else_of_the_path(
    prefix: Path, tmp_path: Path, has_python: bool
) -> None:
    environment, path = tmp_path / "my environment", tmp_path / "path"
    copied = environment / "lib" / PACKAGE / EXECUTABLE
    for folder in (copied.parent, environment / "bin", path):
        folder.mkdir(parents=True)
    shutil.copy(executables(prefix)[0], copied)
    for folder in [path, environment / "bin"] if has_python else [path]:
        python = folder / "python3"
        python.write_text(f'#!/bin/sh\necho "{folder.name}:" "$@"\n')
        python.chmod(0o755)
    shown = subprocess.run(
        [copied, "--ros-args", "-p", "frame_id:=a  b"],
        env={"PATH": f"{path}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        timeout=20,
        check=True,
    )
    assert shown.stdout.startswith(f"{'bin' if has_python else 'path'}: -c ")
    assert shown.stdout.endswith(" imu --backend ros2 --managed --ros-args -p frame_id:=a  b\n")


def test_the_executable_runs_no_modules_of_the_current_folder(prefix: Path, tmp_path: Path) -> None:
    for name in ("rosbase", "json", "rclpy"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('of the current folder')\n")
    shown = subprocess.run(
        [executables(prefix)[0], "--help"], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert "--managed" in shown.stdout


def test_the_reader_waits_for_the_ros_tools_to_bring_it_up_and_then_publishes(
    prefix: Path, client: Client, device: PtyDevice
) -> None:
    got: list[Any] = []
    client.node.create_subscription(Imu, "/imu/data", got.append, 10)
    given = {**device.parameters, "comm_t": "serial", "frame_id": "left"}
    assignments = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
    program = str(executables(prefix)[0])
    with RunningRosbase("--ros-args", *assignments, program=program) as reader:
        client.await_services()
        assert client.state() == "unconfigured"
        assert client.change(Transition.TRANSITION_CONFIGURE)
        assert client.change(Transition.TRANSITION_ACTIVATE)

        def arrives() -> bool:
            device.send(GOOD_FRAME)
            client.executor.spin_once(timeout_sec=0.02)
            return bool(got)

        wait_until(arrives, "a sample")
        assert got[0].header.frame_id == "left"
        assert reader.end(signal.SIGINT) == 0
    assert reader.err.count("Traceback") == 0
