"""An hour of a robot at 200 Hz in virtual time, as a program that prints what happened.

Three nodes, two agents and a task machine. It pushes a cart along a rail between two stations,
and rests when the battery is low.
"""

import hashlib
from typing import Any

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode
from rosbase.fsm import Machine, Transition
from rosbase.messages import Header, String, Time, Twist, Vector3
from rosbase.testing import ManualClock, virtual_backend

TICKS = 720_000
RAIL_M = 3.0


class Cart(BaseNode):
    """Moves as it is told, and says at 50 Hz where it is."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.x, self.speed = 0.0, 0.0
        self.position = self.create_publisher(Vector3, "position")
        self.create_subscription(Twist, "cmd_vel", self.on_velocity)
        self.create_timer(0.02, self.move)

    def on_velocity(self, message: Twist) -> None:
        self.speed = message.linear.x

    def move(self) -> None:
        self.x += self.speed * 0.02
        self.position.publish(Vector3(x=self.x))


class Battery(BaseNode):
    """Says every 0.7 s how full it is."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.charge = 1.0
        self.status = self.create_publisher(String, "battery")
        self.create_subscription(Twist, "cmd_vel", self.on_velocity)
        self.create_timer(0.7, self.report)

    def on_velocity(self, message: Twist) -> None:
        self.charge += -0.0005 if message.linear.x else 0.003
        self.charge = min(1.0, max(0.0, self.charge))

    def report(self) -> None:
        self.status.publish(String("low" if self.charge < 0.2 else "full"))


class Driver(BaseNode):
    """Keeps what came in and sends what is decided."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.x, self.battery = 0.0, "full"
        self.cmd_vel = self.create_publisher(Twist, "cmd_vel")
        self.create_subscription(Vector3, "position", self.on_position)
        self.create_subscription(String, "battery", self.on_battery)

    def on_position(self, message: Vector3) -> None:
        self.x = message.x

    def on_battery(self, message: String) -> None:
        self.battery = message.data


class Planner(BaseAgent):
    """Chooses a speed on every tenth tick."""

    def reset(self) -> None:
        self.speed = 0.0

    def plan(self, goal: float) -> float:
        if self.timestamp % 10 == 0:
            self.speed = max(-1.0, min(1.0, 2.0 * (goal - self.nodes["driver"].x)))
        return self.speed


class Diary(BaseAgent):
    """Keeps a digest of everything that is told."""

    def reset(self) -> None:
        self.digest = hashlib.sha256()
        self.entries = 0

    def tell(self, what: str) -> None:
        stamp: Time = self.get_clock().now()
        self.digest.update(f"{self.timestamp} {Header(stamp, what)}\n".encode())
        self.entries += 1


class Handlers(BaseHandlers):
    """To and fro; to rest when the battery is low."""

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.driver: Driver = self.nodes["driver"]
        self.machine = Machine(
            "OUT",
            [
                Transition(("OUT", "BACK"), "REST", when=lambda: self.driver.battery == "low"),
                Transition("OUT", "BACK", when=lambda: self.driver.x > RAIL_M - 0.05),
                Transition("BACK", "OUT", when=lambda: self.driver.x < 0.05),
                Transition("REST", "BACK", when=lambda: self.machine.steps_in_state >= 4000),
            ],
            during={
                "OUT": lambda: self.drive(RAIL_M),
                "BACK": lambda: self.drive(0.0),
                "REST": lambda: self.driver.cmd_vel.publish(Twist()),
            },
            on_transition=lambda row: self.agents["diary"].tell(f"{row.target} {self.driver.x}"),
        )
        for agent in self.agents.values():
            agent.reset()

    def drive(self, goal: float) -> None:
        speed = self.agents["planner"].plan(goal)
        self.driver.cmd_vel.publish(Twist(linear=Vector3(x=speed)))

    def handle(self) -> None:
        self.machine.step()
        if self.timestamp % 100 == 0:
            self.agents["diary"].tell(f"{self.machine.state} {self.driver.x}")
        if self.timestamp == TICKS - 1:
            self.manager.request_stop()


def main() -> None:
    """Lives through the hour and prints it."""
    # On a busy machine it takes longer than a test in virtual time may by default.
    backend = virtual_backend(ManualClock(real_limit_s=None))
    manager = BaseManager(
        nodes_dict={"driver": Driver, "cart": Cart, "battery": Battery},
        agents_dict={"planner": Planner, "diary": Diary},
        handlers_class=Handlers,
        node_freq_hz=200,
        backend=backend,
    )
    manager.start_main_loop_timer()
    diary, stats = manager.agents["diary"], manager.loop_stats
    print("ticks", manager.timestamp, "skipped", stats.overruns)
    print("seconds", backend.clock.monotonic_ns() / 1e9, "period_ns", stats.period.maximum)
    print("entries", diary.entries, "digest", diary.digest.hexdigest())


if __name__ == "__main__":
    main()
