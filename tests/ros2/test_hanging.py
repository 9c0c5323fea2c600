"""A program that hangs in DDS at its end exits, and says where it hung."""

import signal
from pathlib import Path

from support.program import running

# As rclpy while DDS hangs, `sleep` of the C library holds the GIL here.
PROGRAM = """
import warnings
# rclpy imports a parser that imports what Python has deprecated.
warnings.simplefilter("ignore", DeprecationWarning)
import ctypes
import rclpy.node
from rosbase import LifecycleNode

rclpy.node.Node.destroy_node = lambda node: ctypes.PyDLL(None).sleep(60)
arm = LifecycleNode(node_name="arm", backend="ros2")
# Signals are handled as soon as it spins.
arm.create_timer(0.1, lambda: print("up", flush=True))
arm.start_spin_standalone()
"""


def test_a_program_ends_if_dds_hangs_at_its_end(tmp_path: Path) -> None:
    with running(tmp_path, PROGRAM) as program:
        program.read_until("up")
        took_s, status, _, err = program.stop(signal.SIGINT)
    assert status == 1
    assert took_s < 15
    assert err.startswith("Timeout (0:00:04")
    assert "in destroy_node" in err
