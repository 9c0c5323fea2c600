"""Programs on ROS are recorded, and replayed where there is no ROS."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Vector3 as RosVector3
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter as RosParameter
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from rosgraph_msgs.msg import Clock as RosClock
from std_srvs.srv import SetBool

from support.waiting import wait_until

PROGRAM = """
from rosbase import BaseManager, BaseNode, CallbackReturn, LifecycleNode, ParameterSpec
from rosbase.messages import Vector3
from rosbase.messages.std_srvs import SetBool

class Sailor(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.declare_parameter("gain", 1.5)
        self.declare_parameter("marks", [], ParameterSpec("marks", ["a"]))
        self.add_post_set_parameters_callback(self.tell)
        self.course = self.create_publisher(Vector3, "course", 10)
        self.create_subscription(Vector3, "wind", self.hear, 10)
        self.create_subscription(Vector3, "course", self.hear_own, 10)
        self.create_service(SetBool, "anchor", self.anchor)
        self.create_timer(0.05, self.beat)
        self.beats = 0

    def tell(self, parameters):
        self.logger.info(f"set: {[(p.name, p.value) for p in parameters]}")

    def hear(self, wind):
        gain = self.get_parameter("gain").value
        self.course.publish(Vector3(wind.x * gain, self.get_clock().now_ns() / 1e9))

    def hear_own(self, course):
        self.logger.debug(f"own course {course.x}")

    def anchor(self, request):
        self.logger.info(f"anchor: {request.data}")
        if not request.data:
            self.manager.request_stop()
        return SetBool.Response(True, f"after {self.beats} beats")

    def beat(self):
        self.beats += 1
        self.course.publish(Vector3(-1.0, float(self.beats), self.get_clock().now_ns() / 1e9))


class Mast(LifecycleNode):
    def on_configure(self, state):
        self.declare_parameter("height", 3)
        self.top = self.create_publisher(Vector3, "~/top", 10)
        return CallbackReturn.SUCCESS

    def on_activate(self, state):
        self.top.publish(Vector3(float(self.get_parameter("height").value)))
        return CallbackReturn.SUCCESS


class Ship(BaseManager):
    ticks = 0

    def main_loop(self):
        self.ticks += 1
        if self.ticks == 5:
            self.node(Sailor).declare_parameter("late", "yes")
        if self.ticks % 50 == 0:
            self.logger.info(f"{self.backend.timer_now_ns() > 0} {self.node(Sailor).beats}")


if __name__ == "__main__":
    Ship(
        "ship", {"sailor": Sailor, "mast": Mast}, node_freq_hz=50,
    ).start_main_loop_timer()
"""
TIMEOUT_S = 40.0


class Outside:
    """A node of another process than the program's."""

    def __init__(self, node: Any, executor: Any) -> None:
        self.node = node
        self._executor = executor

    def ask(self, kind: Any, name: str, request: Any) -> Any:
        client = self.node.create_client(kind, name)
        assert client.wait_for_service(TIMEOUT_S), name
        future = client.call_async(request)
        self._executor.spin_until_future_complete(future, TIMEOUT_S)
        assert future.done(), name
        return future.result()

    def set(self, node: str, name: str, value: float) -> bool:
        given = ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
        request = SetParameters.Request(parameters=[RosParameter(name=name, value=given)])
        answer = self.ask(SetParameters, f"{node}/set_parameters", request)
        return bool(answer.results[0].successful)

    def drive(self, node: str, label: str) -> bool:
        request = ChangeState.Request()
        request.transition.label = label
        return bool(self.ask(ChangeState, f"{node}/change_state", request).success)

    def anchor(self, *, drop: bool) -> str:
        return str(self.ask(SetBool, "/anchor", SetBool.Request(data=drop)).message)


@pytest.fixture
def outside(context: Any) -> Iterator[Outside]:
    node: Any = rclpy.create_node("outside", context=context)
    executor: Any = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield Outside(node, executor)
    executor.shutdown()
    node.destroy_node()


@contextmanager
def recorded(folder: Path, *words: str, program: str = PROGRAM) -> Iterator[None]:
    """Records a program in a process of its own, until it ends by itself."""
    (folder / "app.py").write_text(program)
    command = [sys.executable, "-m", "rosbase", "run", "--record", "run.mcap", "--backend", "ros2"]
    process = subprocess.Popen([*command, "app.py", *words], cwd=folder, stderr=subprocess.PIPE)
    try:
        yield
        _, said = process.communicate(timeout=TIMEOUT_S)
        print(said.decode())
        assert process.returncode == 0, said.decode()
    finally:
        if process.poll() is None:
            process.kill()
            print(process.communicate()[1].decode())


def replayed(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Replays the recording in a process that cannot import anything of ROS."""
    for name in ("rclpy", "rcl_interfaces", "std_srvs", "geometry_msgs", "rosbase_ros2"):
        (folder / f"{name}.py").write_text("raise ImportError('there is no ROS')\n")
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    done = subprocess.run(
        [sys.executable, "-m", "rosbase", "replay", "run.mcap", "app.py", *words],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=50,
    )
    print(done.stderr)
    return done


def test_a_program_that_others_operate_is_replayed_without_ros(
    tmp_path: Path, outside: Outside
) -> None:
    wind: Any = outside.node.create_publisher(RosVector3, "/wind", 10)
    with recorded(tmp_path):
        assert outside.anchor(drop=True).startswith("after")
        assert outside.drive("/mast", "configure")
        assert outside.set("/ship", "sailor.gain", 2.5)
        assert not outside.set("/ship", "sailor.marks", 2.5)
        wait_until(lambda: wind.get_subscription_count() == 1, "discovery", TIMEOUT_S)
        for number in range(20):
            wind.publish(RosVector3(x=float(number)))
        assert outside.drive("/mast", "activate")
        assert not outside.drive("/mast", "configure")
        outside.anchor(drop=False)
    done = replayed(tmp_path, "--check")
    assert done.returncode == 0
    assert "no difference" in done.stderr
