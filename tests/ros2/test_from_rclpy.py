"""The two nodes of the page for users of rclpy do the same, started as its launch file says."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
import rclpy
import yaml
from geometry_msgs.msg import Twist
from rcl_interfaces.srv import GetParameters
from rclpy.executors import SingleThreadedExecutor

from support.code_blocks import ROOT, write_files
from support.waiting import wait_until

PAGE = "docs/how-to/from-rclpy.md"


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, dict[str, Any]]:
    """What the launch file says of each node. Launch itself is not in the package index."""
    launch, launch_ros = ModuleType("launch"), ModuleType("launch_ros.actions")
    vars(launch)["LaunchDescription"] = list
    vars(launch_ros)["Node"] = dict
    monkeypatch.setitem(sys.modules, "launch", launch)
    monkeypatch.setitem(sys.modules, "launch_ros", ModuleType("launch_ros"))
    monkeypatch.setitem(sys.modules, "launch_ros.actions", launch_ros)
    write_files(ROOT / PAGE, tmp_path, "")
    names: dict[str, Any] = {}
    exec((tmp_path / "limiter.launch.py").read_text(), names)
    return {node["name"]: node for node in names["generate_launch_description"]()}


@contextmanager
def launched(node: dict[str, Any], folder: Path) -> Iterator["subprocess.Popen[str]"]:
    """A process as launch_ros starts it: parameters in a file, names by remapping."""
    assert node["executable"] == "python3"
    parameters = folder / f"{node['name']}.yaml"
    (values,) = node["parameters"]
    parameters.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    remappings = [("__node", node["name"]), ("__ns", f"/{node['namespace']}"), *node["remappings"]]
    rules = [word for one, other in remappings for word in ("-r", f"{one}:={other}")]
    ros = ["--ros-args", *rules, "--params-file", str(parameters)]
    with subprocess.Popen(
        [sys.executable, *node["arguments"], *ros],
        cwd=folder,
        env={**os.environ, **node.get("additional_env", {})},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()
            process.communicate()


class Driver:
    """Commands a limiter, and sees what becomes of it."""

    def __init__(self, context: Any, namespace: str) -> None:
        self.node: Any = rclpy.create_node("driver", namespace=namespace, context=context)
        self.executor: Any = SingleThreadedExecutor(context=context)
        self.executor.add_node(self.node)
        self.speeds: list[float] = []
        self.sender = self.node.create_publisher(Twist, "cmd_vel_raw", 10)
        self.node.create_subscription(
            Twist, "wheels/cmd_vel", lambda message: self.speeds.append(message.linear.x), 10
        )

    def sees_limited(self) -> bool:
        """Sends a command; whether one has come through."""
        self.sender.publish(_forward(9.0))
        return 0.5 in self._listen()

    def sees_a_stop(self) -> bool:
        """Whether the robot is stopped; nothing is sent any more."""
        return self._listen()[-1] == 0.0

    def max_speed(self, name: str) -> float:
        """The parameter of a node, as `ros2 param get` asks for it."""
        client = self.node.create_client(GetParameters, f"{name}/get_parameters")
        assert client.wait_for_service(20.0)
        answer = client.call_async(GetParameters.Request(names=["max_speed"]))
        self.executor.spin_until_future_complete(answer, 20.0)
        return float(answer.result().values[0].double_value)

    def close(self) -> None:
        """Gives everything back."""
        self.executor.shutdown()
        self.node.destroy_node()

    def _listen(self) -> list[float]:
        self.executor.spin_once(timeout_sec=0.05)
        return self.speeds


def _forward(speed: float) -> Any:
    message = Twist()
    message.linear.x = speed
    return message


@pytest.mark.parametrize("name", ["by_rclpy", "by_rosbase"])
def test_a_node_of_the_page_limits_stops_and_has_the_parameter_of_the_launch_file(
    name: str, described: dict[str, dict[str, Any]], context: Any, tmp_path: Path
) -> None:
    node = described[name]
    with ExitStack() as stack:
        process = stack.enter_context(launched(node, tmp_path))
        driver = Driver(context, node["namespace"])
        stack.callback(driver.close)
        wait_until(driver.sees_limited, f"a limited speed from {name}")
        wait_until(driver.sees_a_stop, f"a stop from {name}")
        assert set(driver.speeds) == {0.0, 0.5}
        assert driver.max_speed(name) == 0.5
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=20)
        assert process.returncode == 0, err
        assert "limit: 0.5 m/s" in out + err
