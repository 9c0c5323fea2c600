"""The quadruped of the examples at 200 Hz with an IMU, driven by a seeded script, as a program.

    rosbase run -p comm_t:=serial -p device_path:=DEVICE tests/support/long_walk.py SECONDS SEED

It walks where a seed says, trips, is sent to its goal, changes a parameter, and turns the IMU off
and on again, for as many seconds as asked for. Then it is stopped, lies down, and prints how many
messages of the IMU it has heard.
"""

import random
import sys
from pathlib import Path
from typing import Any

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "examples" / "quadruped"
sys.path.insert(0, str(EXAMPLE))

import bridge  # noqa: E402 - found on the path of the example
import joystick  # noqa: E402 - found on the path of the example
import legs  # noqa: E402 - found on the path of the example
from manager import QuadrupedManager  # noqa: E402 - found on the path of the example
from planner import Planner  # noqa: E402 - found on the path of the example
from rosbase import ImuReader, State  # noqa: E402 - behind the path, as the rest
from rosbase.messages import Imu, Joy  # noqa: E402 - behind the path, as the rest

RATE_HZ = 200
TWIST_PLAYS = 11 * RATE_HZ
for module in (bridge, joystick, legs):
    module.PERIOD_S = 1 / RATE_HZ


class SeededJoystick(joystick.ScriptedJoystick):
    """Plays what a seed says: random ways, then the way alone, again and again."""

    plays_left = 0
    seed = 0

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        self.random = random.Random(self.seed)
        super().__init__(manager, **kwargs)
        self.plays = 0
        self.axes = joystick.FORWARD
        self.declare_parameter("gain", 1.0)

    def play(self) -> None:
        """Called by the timer."""
        self.plays += 1
        if self.plays >= self.plays_left:
            self.joy.publish(Joy(axes=joystick.CENTRED, buttons=joystick.STOP))
            return
        if self.plays % 100 == 0:
            self.axes = (self.random.uniform(-1, 1), self.random.uniform(-0.2, 1))
        if self.plays % TWIST_PLAYS == 0:
            self.set_parameter("gain", self.random.uniform(0.5, 1.0))
        gain = self.get_parameter("gain").value
        wants_autonomy = self.seen == "human_teleop" and self.plays % 1000 >= 900
        buttons = joystick.AUTONOMOUS if wants_autonomy else joystick.NONE
        self.joy.publish(Joy(axes=[gain * axis for axis in self.axes], buttons=buttons))


class ClumsyLegs(legs.SimulatedLegs):
    """Trips over a stone at every few metres."""

    def stand_up(self) -> None:
        """Rolls onto its feet, then rises."""
        super().stand_up()
        if self.has_tripped and self.roll == 0.0:
            self.has_tripped, self.walked_m = False, 0.0


class Ears(bridge.Bridge):
    """Hears the IMU too, and turns it off and on."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.heard = 0
        self.create_subscription(Imu, "imu/data", self.on_imu)
        self.create_timer(30.0, self.rest_or_wake_up)

    def on_imu(self, message: Imu) -> None:
        """Called with a measurement of the real device."""
        self.heard += 1
        if self.heard % 1000 == 0:
            self.logger.info(f"heard {self.heard}: {message.angular_velocity.z!r}")

    def rest_or_wake_up(self) -> None:
        """Called by a timer."""
        imu = self.manager.node(ImuReader)
        if imu.get_state() is State.ACTIVE:
            imu.trigger_deactivate()
        else:
            imu.trigger_activate()


class LongWalk(QuadrupedManager):
    """Walks for long."""

    def release_resources(self) -> None:
        """Called when the application ends, however it ends."""
        self.node(bridge.Bridge).release_resources()


def main() -> None:
    """Walk."""
    seconds, SeededJoystick.seed = float(sys.argv[1]), int(sys.argv[2])
    SeededJoystick.plays_left = int(seconds * RATE_HZ)
    manager = LongWalk(
        node_name="quadruped",
        nodes_dict={
            "legs": ClumsyLegs,
            "joystick": SeededJoystick,
            "bridge": Ears,
            "imu": ImuReader,
        },
        agents_dict={"planner": Planner},
        node_freq_hz=RATE_HZ,
        start_state="cold_start",
        parameter_defaults={"autostart": "activate"},
    )
    manager.start_main_loop_timer()
    print(f"heard {manager.node(bridge.Bridge).heard} measurements")


if __name__ == "__main__":
    main()
