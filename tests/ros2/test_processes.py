"""Nodes in processes of their own, on ROS: under which name, heard by whom, and their end."""

import signal
from pathlib import Path
from typing import Any

import pytest
import rclpy
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String

from support.program import running
from support.waiting import wait_until

PROGRAM = """
import logging, warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
from rosbase import BaseHandlers, BaseManager, BaseNode, register_multiprocess_nodes
from rosbase.messages import String

class Child(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.say = self.create_publisher(String, "~/answer", 10)
        self.create_timer(0.02, self.talk)
    def talk(self):
        self.say.publish(String("hello"))
        self.logger.warning("hm")

class Parent(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.heard = set()
        for topic in ("/robot/eye/answer", "/robot/ear/answer"):
            self.create_subscription(String, topic, lambda m, t=topic: self.heard.add(t), 10)

class Log(logging.Handler):
    said = set()
    def emit(self, record):
        self.said.add((record.levelname, record.getMessage()))

class Handlers(BaseHandlers):
    def handle(self):
        wanted = {("WARNING", "eye: hm"), ("WARNING", "ear: hm")}
        if len(self.nodes["parent"].heard) == 2 and wanted <= Log.said:
            print("heard and logged", flush=True)
        elif self.timestamp > 400:
            self.manager.request_stop()

if __name__ == "__main__":
    logging.getLogger("rosbase").addHandler(Log())
    processes = register_multiprocess_nodes({"eye": Child, "ear": Child}, {"nap": "sleep 100"})
    app = BaseManager("boss", {"parent": Parent}, None, Handlers, 20)
    app.start_main_loop_timer(processes)
"""


def test_nodes_in_children_are_ros_nodes_of_their_own_names_and_end_with_the_manager(
    tmp_path: Path, context: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ROSBASE_BACKEND", "ros2")
    node: Any = rclpy.create_node("plain", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard: list[String] = []
    node.create_subscription(String, "/robot/eye/answer", heard.append, 10)
    # As a launch file names a node.
    names = ("--ros-args", "-r", "__node:=chief", "-r", "__ns:=/robot")

    def has_met_them() -> bool:
        executor.spin_once(timeout_sec=0.1)
        found = node.get_node_names_and_namespaces()
        names = {name for name, namespace in found if namespace == "/robot"}
        return bool(heard) and names == {"chief", "eye", "ear"}

    with running(tmp_path, PROGRAM, *names) as program:
        program.read_until("heard and logged")
        wait_until(has_met_them, "a message of a child, and three names")
        program.process.send_signal(signal.SIGINT)
        status, _, err = program.end()
        assert status == 0
        assert "Traceback" not in err
        assert not program.family()
    executor.shutdown()
    node.destroy_node()
