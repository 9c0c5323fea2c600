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

from rosbase.messages import Vector3
from rosbase.runtime.executor import Executor
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.parameters import RosParameters
from rosbase_ros2.topics import RosPublisher, RosSubscription
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
ROS = ("rclpy", "rcl_interfaces", "lifecycle_msgs", "std_srvs", "geometry_msgs", "rosbase_ros2")


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

    def spin_once(self, timeout_s: float = 0.1) -> None:
        self._executor.spin_once(timeout_s)

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
def recorded(folder: Path, *words: str, program: str = PROGRAM) -> Iterator[Any]:
    """Records a program in a process of its own, until it ends by itself."""
    (folder / "app.py").write_text(program)
    command = [sys.executable, "-m", "rosbase", "run", "--record", "run.mcap", "--backend", "ros2"]
    process = subprocess.Popen([*command, "app.py", *words], cwd=folder, stderr=subprocess.PIPE)
    try:
        yield process
        _, said = process.communicate(timeout=TIMEOUT_S)
        print(said.decode())
        assert process.returncode == 0, said.decode()
    finally:
        if process.poll() is None:
            process.kill()
            print(process.communicate()[1].decode())


def replayed(folder: Path, *words: str, has_ros: bool = False) -> subprocess.CompletedProcess[str]:
    """Replays the recording in a process that cannot import anything of ROS, if not told so."""
    for name in () if has_ros else ROS:
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


THREADS = """
import sys, threading
from rosbase import BaseManager, BaseNode
from rosbase.messages import Vector3
from rosbase.messages.std_srvs import SetBool

class Caller(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.client = self.create_client(SetBool, "permit")
        self.own = self.create_client(SetBool, "self")
        self.create_service(SetBool, "self", lambda request: SetBool.Response(request.data, "own"))
        self.point = self.create_publisher(Vector3, "point", 10)
        self.create_subscription(Vector3, "wind", self.hear, 2)
        self.create_timer(0.02, self.beat)
        self.beats = 0
        thread = threading.Thread(target=self.publish_all)
        thread.start()

    def publish_all(self):
        for number in range(50):
            self.point.publish(Vector3(float(number)))

    def hear(self, wind):
        self.logger.info(f"wind {wind.x} of {self.point.subscription_count}")

    def beat(self):
        self.beats += 1
        if self.beats == 3 and self.client.wait_for_service(20.0):
            answer = self.client.call(SetBool.Request(True), 20.0)
            self.logger.info(f"first: {answer.message}")
            self.logger.info(f"own: {self.own.call(SetBool.Request(False), 5.0).message}")
            self.client.call_async(SetBool.Request(False), 20.0).add_done_callback(self.done)

    def done(self, future):
        self.logger.info(f"second: {future.result().message}")
        self.manager.request_stop()


class Robot(BaseManager):
    pass

if __name__ == "__main__":
    Robot("robot", {"caller": Caller}, node_freq_hz=100).start_main_loop_timer()
"""


def test_answers_of_others_and_messages_of_own_threads_are_replayed(
    tmp_path: Path, outside: Outside
) -> None:
    def permit(request: Any, response: Any) -> Any:
        response.message = f"said {request.data}"
        return response

    outside.node.create_service(SetBool, "/fleet/permit", permit)
    words = ("--ros-args", "-r", "permit:=/fleet/permit", "-r", "__ns:=/fleet", "-r", "point:=p")
    with recorded(tmp_path, *words, program=THREADS) as process:
        while process.poll() is None:
            outside.spin_once()
    done = replayed(tmp_path, "--check")
    assert done.returncode == 0
    assert "no difference" in done.stderr
    assert "second: said False" in done.stderr


SIMULATED = """
from rosbase import BaseManager, BaseNode
from rosbase.messages import Vector3

class Clockwork(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.point = self.create_publisher(Vector3, "point", 10)
        self.timer = self.create_timer(0.5, self.beat)
        self.beats = 0

    def beat(self):
        self.beats += 1
        self.point.publish(Vector3(float(self.beats), self.get_clock().now_ns() / 1e9))
        if self.beats == 4:
            self.timer.reset()
        if self.beats == 8:
            self.manager.request_stop()

class Robot(BaseManager):
    ticks = 0

    def main_loop(self):
        self.ticks += 1
        if self.ticks % 20 == 0:
            self.logger.info(f"at {self.backend.timer_now_ns()}")

if __name__ == "__main__":
    Robot("robot", {"clockwork": Clockwork}, node_freq_hz=50).start_main_loop_timer()
"""


def test_simulated_time_is_replayed(tmp_path: Path, outside: Outside) -> None:
    clock: Any = outside.node.create_publisher(RosClock, "/clock", 10)
    now_s = 1000.0
    words = ("--ros-args", "-p", "use_sim_time:=true")
    with recorded(tmp_path, *words, program=SIMULATED) as process:
        while process.poll() is None:
            now_s += 0.05
            message = RosClock()
            message.clock.sec, message.clock.nanosec = int(now_s), int(now_s % 1 * 1e9)
            clock.publish(message)
            # Not faster than the program can follow.
            outside.spin_once(0.01)
    done = replayed(tmp_path, "--check")
    assert done.returncode == 0
    assert "no difference" in done.stderr


NATIVE = """
from rosbase import BaseManager

class Robot(BaseManager):
    ticks = 0

    def main_loop(self):
        self.ticks += 1
        if self.ticks == 5:
            self.backend.node.create_timer(1.0, print)
        if self.ticks == 10:
            self.request_stop()

if __name__ == "__main__":
    Robot("robot", node_freq_hz=50).start_main_loop_timer()
"""


def test_what_the_program_makes_with_rclpy_itself_spoils_the_recording(tmp_path: Path) -> None:
    with recorded(tmp_path, program=NATIVE):
        pass
    done = replayed(tmp_path, "--check")
    assert done.returncode == 1
    assert "the program uses the rclpy node robot itself, which a replay lacks" in done.stderr


def test_a_changed_program_is_found(tmp_path: Path, outside: Outside) -> None:
    with recorded(tmp_path):
        while outside.anchor(drop=True) == "after 0 beats":
            pass
        outside.anchor(drop=False)
    app = tmp_path / "app.py"
    app.write_text(PROGRAM.replace("Vector3(-1.0,", "Vector3(-1.5,"))
    done = replayed(tmp_path, "--check")
    assert done.returncode == 1
    assert "x: -1 -> -1.5" in done.stderr.replace(".0", "")


OF_ROS = """
from geometry_msgs.msg import PointStamped, Vector3
from std_srvs.srv import SetBool
from rosbase import BaseManager, BaseNode

class Native(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.message = PointStamped()
        self.point = self.create_publisher(PointStamped, "point", 10)
        self.create_subscription(Vector3, "wind", self.hear, 10)
        self.create_service(SetBool, "anchor", self.anchor)

    def hear(self, wind):
        self.message.header.frame_id += "x"
        self.message.point.y = wind.x
        self.point.publish(self.message)

    def anchor(self, request, response):
        response.message = "after"
        self.logger.info(f"anchor {request.data}")
        if not request.data:
            self.manager.request_stop()
        return response

if __name__ == "__main__":
    BaseManager("robot", {"native": Native}, node_freq_hz=50).start_main_loop_timer()
"""


def test_classes_of_ros_are_replayed_where_they_are_installed(
    tmp_path: Path, outside: Outside
) -> None:
    wind: Any = outside.node.create_publisher(RosVector3, "/wind", 10)
    with recorded(tmp_path, program=OF_ROS):
        assert outside.anchor(drop=True) == "after"
        wait_until(lambda: wind.get_subscription_count() == 1, "discovery", TIMEOUT_S)
        for number in range(5):
            wind.publish(RosVector3(x=float(number)))
        outside.anchor(drop=False)
    done = replayed(tmp_path, "--check", has_ros=True)
    assert done.returncode == 0
    assert "no difference" in done.stderr
    lacking = replayed(tmp_path, "--check")
    assert lacking.returncode != 0


def test_without_a_recording_the_plain_classes_are_used(backend: Ros2Backend) -> None:
    assert type(backend.create_publisher(Vector3, "wind", 1)) is RosPublisher
    assert type(backend.create_subscription(Vector3, "wind", print, 1)) is RosSubscription
    assert type(backend._parameters) is RosParameters
    assert type(backend.executor) is Executor


SPOILT = """
import threading
from rosbase import BaseManager, BaseNode
from rosbase.messages import Vector3

class Loose(BaseNode):
    def __init__(self, *args, **kwargs):
        super().__init__(*args, **kwargs)
        self.declare_parameter("gain", 1.0)
        self.create_timer(0.1, self.beat)

    def beat(self):
        thread = threading.Thread(target=self.change)
        thread.start()
        thread.join()
        self.manager.request_stop()

    def change(self):
        ACTION

if __name__ == "__main__":
    BaseManager("robot", {"loose": Loose}, node_freq_hz=50).start_main_loop_timer()
"""


@pytest.mark.parametrize(
    ("action", "reason"),
    [
        ('self.create_publisher(Vector3, "late", 1)', "created a publisher: /late"),
        ('self.declare_parameter("late", 1)', "a thread of the program's own declares a parameter"),
    ],
    ids=["creates", "declares"],
)
def test_what_own_threads_create_spoils_the_recording(
    tmp_path: Path, action: str, reason: str
) -> None:
    with recorded(tmp_path, program=SPOILT.replace("ACTION", action)):
        pass
    done = replayed(tmp_path, "--check")
    assert done.returncode == 1
    assert reason in done.stderr
