"""A program that is neither recorded nor replayed pays nothing for recordings."""

import json
import subprocess
import sys

PROGRAM = """
import json, sys
from rosbase import BaseHandlers, BaseManager, LifecycleNode
from rosbase.messages import Vector3
from rosbase.messages.std_srvs import SetBool

class Handlers(BaseHandlers):
    def handle(self):
        self.manager.nodes["camera"].publisher.publish(Vector3())
        if self.timestamp > 3:
            self.manager.request_stop()

class Camera(LifecycleNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.publisher = self.create_publisher(Vector3, "speed", 10)
        self.create_subscription(Vector3, "speed", list, 10)
        self.create_service(SetBool, "switch", lambda _: SetBool.Response())
        self.create_client(SetBool, "switch")
        self.create_timer(0.01, self.get_clock().now)

BaseManager(nodes_dict={"camera": Camera}, handlers_class=Handlers).start_main_loop_timer()
print(json.dumps([name for name in sys.modules if name.startswith("rosbase.")]))
"""
SMALL = {"conductor", "current", "kinds"}
"""Modules that say whether there is a recording."""


def test_it_imports_nothing_of_them() -> None:
    ran = subprocess.run(
        [sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True, timeout=50
    )
    modules = json.loads(ran.stdout.splitlines()[-1])
    prefix = "rosbase.entries."
    assert {name.removeprefix(prefix) for name in modules if name.startswith(prefix)} <= SMALL
    words = ("conducted", "entrance", "guarded", "recorded", "replayed")
    assert [name for name in modules if any(word in name for word in words)] == []
