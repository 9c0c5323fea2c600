"""What the robot does: the task, as a table of transitions."""

from typing import Any

from bridge import Bridge
from confirmer import Confirmer
from rosbase import BaseHandlers
from rosbase.fsm import Machine, Transition
from tracker import Tracker

# In ticks, at 50 a second.
ANSWER_TICKS = 25
GRIPPER_TICKS = 15

FACING_RAD = 0.08
CLOSE_M = 0.3
HELD_M = 0.01


class PickPlaceHandlers(BaseHandlers):
    """Picks up the cup and puts it onto the tray.

    The machine owns the fine-grained state; `manager.state` stays what the manager began with.
    """

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.machine = Machine(
            "WAIT_FOR_PICK_TARGET",
            [
                Transition("WAIT_FOR_PICK_TARGET", "ROTATE_TO_PICK", when=self.sees_target),
                Transition(
                    ("ROTATE_TO_PICK", "APPROACH_PICK"),
                    "WAIT_FOR_PICK_TARGET",
                    when=self.lost_target,
                ),
                Transition("ROTATE_TO_PICK", "APPROACH_PICK", when=self.is_facing),
                Transition("APPROACH_PICK", "AI_CONFIRM_PICK", when=self.is_close),
                Transition("AI_CONFIRM_PICK", "GRASP_EXECUTION", when=self.is_confirmed),
                Transition("AI_CONFIRM_PICK", "ROTATE_TO_PICK", when=self.is_refused),
                Transition("AI_CONFIRM_PICK", "ROTATE_TO_PICK", when=self.got_no_answer),
                Transition("GRASP_EXECUTION", "WAIT_FOR_PLACE_TARGET", when=self.is_holding),
                Transition("GRASP_EXECUTION", "ROTATE_TO_PICK", when=self.has_slipped),
                Transition("WAIT_FOR_PLACE_TARGET", "ROTATE_TO_PLACE", when=self.sees_target),
                Transition("ROTATE_TO_PLACE", "WAIT_FOR_PLACE_TARGET", when=self.lost_target),
                Transition("ROTATE_TO_PLACE", "AI_CONFIRM_PLACE", when=self.is_facing),
                Transition("AI_CONFIRM_PLACE", "RELEASE_EXECUTION", when=self.is_confirmed),
                Transition("AI_CONFIRM_PLACE", "ROTATE_TO_PLACE", when=self.is_refused),
                Transition("AI_CONFIRM_PLACE", "ROTATE_TO_PLACE", when=self.got_no_answer),
                Transition("RELEASE_EXECUTION", "FINISHED", when=self.has_released),
            ],
            on_enter={
                "WAIT_FOR_PICK_TARGET": lambda: self.tracker.look_for("cup"),
                "ROTATE_TO_PICK": lambda: self.bridge.open_gripper(),
                "AI_CONFIRM_PICK": self.ask,
                "GRASP_EXECUTION": lambda: self.bridge.close_gripper(),
                "WAIT_FOR_PLACE_TARGET": lambda: self.tracker.look_for("tray"),
                "AI_CONFIRM_PLACE": self.ask,
                "RELEASE_EXECUTION": lambda: self.bridge.open_gripper(),
                "FINISHED": lambda: self.manager.request_stop(),
            },
            during={
                "WAIT_FOR_PICK_TARGET": self.search,
                "ROTATE_TO_PICK": self.rotate,
                "APPROACH_PICK": self.approach,
                "AI_CONFIRM_PICK": lambda: self.confirmer.think(),
                "WAIT_FOR_PLACE_TARGET": self.search,
                "ROTATE_TO_PLACE": self.rotate,
                "AI_CONFIRM_PLACE": lambda: self.confirmer.think(),
            },
            on_transition=self.report,
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
        """The way to the robot."""
        return self.node(Bridge)

    @property
    def tracker(self) -> Tracker:
        """Where the target is."""
        return self.node(Tracker)

    @property
    def confirmer(self) -> Confirmer:
        """Who is asked before something is done that cannot be undone."""
        return self.agent(Confirmer)

    # When: guards only look.

    def sees_target(self) -> bool:
        """The target is in the last picture."""
        return self.tracker.position is not None

    def lost_target(self) -> bool:
        """The target is not in the last picture."""
        return self.tracker.position is None

    def is_facing(self) -> bool:
        """The target is straight ahead."""
        return self.sees_target() and abs(self.tracker.bearing_rad) < FACING_RAD

    def is_close(self) -> bool:
        """The target is within the arm's reach."""
        return self.sees_target() and self.tracker.distance_m < CLOSE_M

    def is_confirmed(self) -> bool:
        """The AI has said yes."""
        return self.confirmer.verdict is True

    def is_refused(self) -> bool:
        """The AI has said no."""
        return self.confirmer.verdict is False

    def got_no_answer(self) -> bool:
        """The AI has taken too long."""
        return self.machine.steps_in_state >= ANSWER_TICKS

    def is_holding(self) -> bool:
        """The fingers have had time to close, and something is between them."""
        return self.gripper_is_done() and self.bridge.fingers_m > HELD_M

    def has_slipped(self) -> bool:
        """The fingers have had time to close, and nothing is between them."""
        return self.gripper_is_done() and self.bridge.fingers_m <= HELD_M

    def has_released(self) -> bool:
        """The fingers have had time to open."""
        return self.gripper_is_done()

    def gripper_is_done(self) -> bool:
        """The fingers have had time to move."""
        return self.machine.steps_in_state >= GRIPPER_TICKS

    # What: actions do one thing and return at once.

    def ask(self) -> None:
        """Stands still and asks the AI anew."""
        self.bridge.stop()
        self.confirmer.reset()

    def search(self) -> None:
        """Turns until something comes into view."""
        self.bridge.drive(0.0, 1.5)

    def rotate(self) -> None:
        """Turns to the target."""
        self.bridge.drive(0.0, 4.0 * self.tracker.bearing_rad)

    def approach(self) -> None:
        """Drives to the target, slower when it is near."""
        speed = min(1.0, 3.0 * (self.tracker.distance_m - CLOSE_M) + 0.2)
        self.bridge.drive(speed, 4.0 * self.tracker.bearing_rad)
