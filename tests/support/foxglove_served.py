"""`rosbase view --foxglove` as a process, and programs that it serves."""

import re
from collections.abc import Iterator
from contextlib import contextmanager

from support.command import RunningRosbase

__all__ = ["BOARDS", "port_of", "served"]

BOARDS = """
import sys
from rosbase import BaseHandlers, BaseManager, BaseNode, DurabilityPolicy, QoSProfile
from rosbase.messages import Header, Imu, Quaternion, String, Time

HZ, EACH = float(sys.argv[1]), int(sys.argv[2])


class Board(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.imu = self.create_publisher(Imu, "imu/data")
        kept = QoSProfile(1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_publisher(String, "model", kept).publish(String("two boards"))
        self.objects = self.create_publisher(set, "objects")


class Handlers(BaseHandlers):
    def handle(self):
        for n in range(self.timestamp * EACH, (self.timestamp + 1) * EACH):
            # Its number is its stamp; it is turned by a quarter about z, and has not the norm 1.
            header = Header(Time(n // 1_000, n % 1_000), "imu_link")
            self.node(Board).imu.publish(Imu(header, Quaternion(0.0, 0.0, 2.0, 2.0)))
        self.node(Board).objects.publish({self.timestamp})
        if self.timestamp == 5:
            print("ready", flush=True)


manager = BaseManager("boards", {"board": Board}, {}, Handlers, node_freq_hz=HZ)
manager.start_main_loop_timer()
"""
"""Publishes Imus, a text that it keeps, and objects without a type.

Its arguments are the rate of its ticks, and the number of Imus in each.
"""


@contextmanager
def served(*arguments: str) -> Iterator[tuple[RunningRosbase, int]]:
    """Serves on a port of its own; gives the process and the port."""
    with RunningRosbase("view", "--foxglove", "0", *arguments) as view:
        yield view, port_of(view)


def port_of(view: RunningRosbase) -> int:
    """Waits for the port that a server prints."""
    view.waits_for("ws://", where=view.out)
    found = re.search(r"ws://127\.0\.0\.1:(\d+)", "\n".join(view.out.lines))
    assert found is not None
    return int(found[1])
