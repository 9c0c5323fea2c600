"""The program of `format_1.mcap`. Never change it: record another one beside it."""

import threading
from pathlib import Path
from typing import Any

from rosbase import BaseManager, BaseNode, LifecycleNode, RecordOptions
from rosbase.messages import Vector3

__all__ = ["Robot"]

_TICKS = 20


class Talker(BaseNode):
    """Publishes what depends on the order of timers and messages, on the clock and parameters."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.declare_parameter("speed", 1.5)
        self.count = 0
        self.point = self.create_publisher(Vector3, "point", 10)
        self.out = self.create_publisher(Vector3, "out", 10)
        self.create_subscription(Vector3, "point", self.on_point, 10)
        self.create_timer(0.017, self.on_first)
        self.create_timer(0.05, self.on_second)

    def on_first(self) -> None:
        self.count += 1
        now_s = self.get_clock().monotonic_ns() / 1e9
        self.point.publish(Vector3(float(self.count), now_s, float(self.get_clock().now_ns())))

    def on_second(self) -> None:
        self.count = self.count * 2 % 1000
        self.logger.info(f"the count is {self.count}")
        self.set_parameter("speed", float(self.count))

    def on_point(self, message: Vector3) -> None:
        self.out.publish(Vector3(message.x, message.y, message.z))


class Robot(BaseManager):
    """Has a thread of its own that publishes. Ends by itself."""

    def __init__(self, record: RecordOptions | None = None) -> None:
        nodes = {"talker": Talker, "arm": LifecycleNode}
        super().__init__("robot", nodes, node_freq_hz=50.0, record=record)
        self.own = self.node(Talker).create_publisher(Vector3, "own", 10)
        self.is_over = threading.Event()

        self.thread = threading.Thread(target=self._publish, name="own")

    def run(self) -> None:
        """Run to the end."""
        self.thread.start()
        self.start_main_loop_timer()

    def update_timestamp(self) -> None:
        super().update_timestamp()
        if self.timestamp == _TICKS:
            self.is_over.set()
            self.thread.join()
            self.request_stop()

    def _publish(self) -> None:
        number = 0
        while not self.is_over.wait(0.03):
            number += 1
            self.own.publish(Vector3(float(number)))


if __name__ == "__main__":
    Robot(RecordOptions(Path("format_1.mcap"))).run()
