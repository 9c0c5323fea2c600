"""What the robot does: its states, as a table of transitions."""

from typing import Any

from bridge import Bridge
from planner import Planner
from rosbase import BaseHandlers
from rosbase.fsm import ANY, Machine, Transition

AUTONOMOUS_BUTTON = 0

FACING_RAD = 0.15
ARRIVED_M = 0.15
LIE_DOWN_TICKS = 25


class QuadrupedHandlers(BaseHandlers):
    """Walks where the operator or the planner wants, and gets up after a fall.

    `self.state` is the manager's state. The machine drives it, and follows when others set it.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.machine = Machine(
            "cold_start",
            [
                Transition(ANY, "emergency", when=self.wants_stop),
                Transition("cold_start", "human_teleop", when=self.is_standing),
                Transition(
                    ("human_teleop", "turn", "navigation"), "recovery", when=self.has_fallen
                ),
                Transition("recovery", "turn", when=self.is_standing_on_its_way),
                Transition("recovery", "human_teleop", when=self.is_standing),
                Transition("human_teleop", "turn", when=self.wants_autonomy),
                Transition("turn", "navigation", when=self.is_facing),
                Transition("navigation", "human_teleop", when=self.has_arrived),
            ],
            on_enter={"turn": lambda: self.planner.reset()},
            during={
                "cold_start": self.stand_up,
                "recovery": self.stand_up,
                "human_teleop": self.obey,
                "turn": self.turn,
                "navigation": self.navigate,
                "emergency": self.lie_down,
            },
            on_transition=self.report,
            holder=self,
        )

    def handle(self) -> None:
        """Called once per tick."""
        self.machine.step()

    def report(self, transition: Transition) -> None:
        """Called after each transition."""
        print(f"{self.machine.previous} -> {self.machine.state} {transition.reason}", flush=True)

    # The components that the task works with.

    @property
    def bridge(self) -> Bridge:
        """The way to legs and operator."""
        return self.node(Bridge)

    @property
    def planner(self) -> Planner:
        """The way to the goal."""
        return self.agent(Planner)

    # When: guards only look.

    def wants_stop(self) -> bool:
        """The operator has pressed the emergency stop."""
        return self.bridge.is_stopped

    def wants_autonomy(self) -> bool:
        """The operator wants the robot to find its way alone."""
        return self.bridge.is_pressed(AUTONOMOUS_BUTTON)

    def is_standing(self) -> bool:
        """The robot is on its feet."""
        return self.bridge.is_standing()

    def is_standing_on_its_way(self) -> bool:
        """The robot is on its feet again, and was alone when it fell."""
        return self.is_standing() and self.machine.previous != "human_teleop"

    def has_fallen(self) -> bool:
        """The robot lies on its side."""
        return self.bridge.has_fallen()

    def is_facing(self) -> bool:
        """The goal is straight ahead."""
        return abs(self.planner.bearing_rad) < FACING_RAD

    def has_arrived(self) -> bool:
        """The goal is reached."""
        return self.planner.distance_m < ARRIVED_M

    # What: actions do one thing and return at once.

    def stand_up(self) -> None:
        """Gets onto its feet."""
        self.bridge.command("stand")

    def obey(self) -> None:
        """Does what the operator's stick asks for."""
        self.bridge.command("walk", self.bridge.stick())

    def turn(self) -> None:
        """Turns to the goal."""
        self.plan()
        self.bridge.command("walk", self.planner.turn())

    def navigate(self) -> None:
        """Walks to the goal."""
        self.plan()
        self.bridge.command("walk", self.planner.walk())

    def plan(self) -> None:
        """Has the planner look at where the robot is."""
        if self.bridge.pose.value is not None:
            self.planner.plan(self.bridge.pose.value.pose)

    def lie_down(self) -> None:
        """Lies down, and ends the run."""
        self.bridge.command("lie")
        if self.machine.steps_in_state >= LIE_DOWN_TICKS:
            self.manager.request_stop()
