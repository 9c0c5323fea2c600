"""The last messages: they arrive although their publisher was destroyed right after them."""

import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from std_msgs.msg import String as RosString

from rosbase.messages import String
from rosbase_ros2.backend import Ros2Backend
from rosbase_ros2.delivery import await_delivery
from support.program import Program, running
from support.ros import spin_until
from support.waiting import wait_until

# Plain rclpy; says which messages it has got.
ECHO = """
import warnings
warnings.simplefilter("ignore", DeprecationWarning)
import rclpy
from rclpy.executors import ExternalShutdownException
from std_msgs.msg import String
rclpy.init()
node = rclpy.create_node("echo")
answers = node.create_publisher(String, "echo", 1000)
node.create_subscription(
    String, "words", lambda message: answers.publish(String(data=message.data.strip())), 1000
)
try:
    rclpy.spin(node)
except (ExternalShutdownException, KeyboardInterrupt):
    pass
node.destroy_node()
"""
MANY = 30
# More than the kernel keeps for a process that does not read.
BIG = " " * 60_000


class Echo:
    """A subscriber in another process, which has found the publisher of the test."""

    def __init__(self, backend: Ros2Backend, program: Program) -> None:
        self.program = program
        self.heard: list[String] = []
        self.publisher = backend.create_publisher(String, "words", 1000)
        backend.create_subscription(String, "echo", self.heard.append, 1000)
        timer = backend.create_timer(0.02, lambda: self.publisher.publish(String("hello")))
        spin_until(backend, lambda: self.heard)
        backend.destroy_timer(timer)

    def stop(self) -> None:
        """Has it hang, as in a debugger."""
        pid = self.program.process.pid
        os.kill(pid, signal.SIGSTOP)
        state = Path(f"/proc/{pid}/stat")
        wait_until(lambda: state.read_text().rpartition(")")[2].split()[0] == "T", "it to hang")

    def resume(self) -> None:
        """Has it go on."""
        os.kill(self.program.process.pid, signal.SIGCONT)


@pytest.fixture
def echo(backend: Ros2Backend, tmp_path: Path) -> Iterator[Echo]:
    with running(tmp_path, ECHO) as program:
        yield Echo(backend, program)


def test_what_was_published_before_its_publisher_was_destroyed_arrives(
    backend: Ros2Backend, echo: Echo
) -> None:
    echo.stop()
    for number in range(MANY):
        echo.publisher.publish(String(f"{number}{BIG}"))
    backend.destroy_publisher(echo.publisher)
    echo.publisher.publish(String("too late"))
    echo.resume()
    spin_until(backend, lambda: String(str(MANY - 1)) in echo.heard)
    words = [message.data for message in echo.heard if message.data != "hello"]
    assert words == [str(number) for number in range(MANY)]
    # Once nothing is on its way to anybody, the publisher is gone from the graph.
    echo.program.process.send_signal(signal.SIGINT)
    spin_until(backend, lambda: backend.node.count_publishers("/words") == 0)


def test_a_subscriber_that_hangs_holds_up_no_destroying_and_half_a_second_of_the_end(
    backend: Ros2Backend, echo: Echo
) -> None:
    monotonic_ns = backend.executor.clock.monotonic_ns
    echo.stop()
    echo.publisher.publish(String("unheard"))
    start_ns = monotonic_ns()
    backend.destroy_publisher(echo.publisher)
    assert monotonic_ns() - start_ns < 300_000_000
    # Other threads run on meanwhile, which they would not if rclpy waited.
    turns: list[int] = []
    ended = threading.Event()

    def turn() -> None:
        while not ended.wait(0.001):
            turns.append(1)

    thread = threading.Thread(target=turn)
    thread.start()
    start_ns = monotonic_ns()
    backend.close()
    took_ns = monotonic_ns() - start_ns
    ended.set()
    thread.join()
    assert 400_000_000 < took_ns < 2_000_000_000
    assert len(turns) > 20


def test_the_end_does_not_wait_for_a_publisher_that_is_destroyed_meanwhile(
    backend: Ros2Backend,
) -> None:
    by_hand = backend.node.create_publisher(RosString, "words", 10)
    backend.node.destroy_publisher(by_hand)
    await_delivery([by_hand], 60.0, backend.executor.clock)
