"""The quadruped at 200 Hz, with the reader of a real IMU and a seeded operator.

`rosbase run field_robot --ticks N -p imu.device_path:=/dev/pts/5` runs it. The IMU is that of
`rosbase simulate --rate 200`, in another process.
"""

import os
import random
import sys
from argparse import ArgumentParser
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[3] / "docs" / "examples" / "quadruped"))

from bridge import Bridge
from joystick import AUTONOMOUS, NONE, ScriptedJoystick
from legs import SimulatedLegs
from manager import QuadrupedManager
from planner import Planner
from rosbase import ImuReader, Latest
from rosbase.messages import Imu, Joy, Twist, Vector3

SEED = 19
# A replay has the arguments of its recording, so what a test changes comes another way.
GAIN = float(os.environ.get("FIELD_ROBOT_GAIN", "0.1"))


class Operator(ScriptedJoystick):
    """Moves the stick at random, from a seed, and often lets the robot walk alone."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.random = random.Random(SEED)

    def play(self) -> None:
        draw = self.random
        self.periods += 1
        buttons = AUTONOMOUS if draw.random() < 0.01 else NONE
        self.joy.publish(Joy(axes=(draw.uniform(-1, 1), draw.uniform(-1, 1)), buttons=buttons))


class FieldManager(QuadrupedManager):
    """Walks for some ticks, and steers against what the IMU measures."""

    def __init__(self, ticks: int, **kwargs: Any) -> None:
        self.ticks = ticks
        nodes = {
            "legs": SimulatedLegs,
            "joystick": Operator,
            "bridge": Bridge,
            "imu": ImuReader,
        }
        super().__init__(
            "field",
            nodes,
            {"planner": Planner},
            node_freq_hz=200,
            start_state="cold_start",
            parameter_defaults={"imu.autostart": "activate"},
            **kwargs,
        )
        self.measured: Latest[Imu] = self.node(Bridge).latest(Imu, "imu/data")

    def main_loop(self) -> None:
        super().main_loop()
        bridge = self.node(Bridge)
        if self.measured.value is not None:
            now = bridge.velocity
            turn = now.angular.z - GAIN * self.measured.value.angular_velocity.z
            bridge.command(bridge.gait, Twist(now.linear, Vector3(z=turn)))
        if self.timestamp == self.ticks:
            self.request_stop()


def main() -> None:
    """Run the robot."""
    parser = ArgumentParser()
    parser.add_argument("--ticks", type=int, default=2000)
    FieldManager(parser.parse_args().ticks).start_main_loop_timer()


if __name__ == "__main__":
    main()
