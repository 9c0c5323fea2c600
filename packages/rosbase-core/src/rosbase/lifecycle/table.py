"""The ROS 2 lifecycle as data: 11 states, 25 transitions. No other module decides anything.

Source: lifecycle_msgs/msg/State and Transition for ids, and rcl_lifecycle's
`default_state_machine.c` for labels, edges and their order, which the ROS tools see. Where the
design article (design.ros2.org/articles/node_lifecycle) differs from that code, rosbase follows
the code:

- there is no edge from active to errorprocessing; `raise_error` is our extension and is
  kept out of this table;
- FAILURE leads back from activating, deactivating and cleaningup too, and from
  shuttingdown on to finalized.

CREATE (0) and DESTROY (8) are defined in lifecycle_msgs and registered nowhere, so they
are not here. Ids from 10 up belong to the callbacks: nobody may request them.
"""

from enum import IntEnum

from attrs import frozen

__all__ = [
    "CALLBACKS",
    "RAISE_ERROR_LABEL",
    "TRANSITIONS",
    "CallbackReturn",
    "State",
    "Transition",
    "starting_at",
]


class State(IntEnum):
    """A state of a managed node. The value is its id in lifecycle_msgs/State.

    `str(State.ACTIVE)` is its label, `active`; `int(State.ACTIVE)` is its id.
    """

    UNKNOWN = 0
    UNCONFIGURED = 1
    INACTIVE = 2
    ACTIVE = 3
    FINALIZED = 4
    CONFIGURING = 10
    CLEANINGUP = 11
    SHUTTINGDOWN = 12
    ACTIVATING = 13
    DEACTIVATING = 14
    ERRORPROCESSING = 15

    def __str__(self) -> str:
        return self.label

    def __format__(self, spec: str) -> str:
        # As from Python 3.11 on: the label without a specification, the id with one such as `d`.
        return int.__format__(self, spec)

    @property
    def id(self) -> int:
        """Number of the state in lifecycle_msgs."""
        return self.value

    @property
    def label(self) -> str:
        """Name that the ROS tools show: lower case, one word."""
        return self.name.lower()

    @property
    def is_primary(self) -> bool:
        """Whether a node can rest in it. The others last as long as a callback runs."""
        return self.value < 10


class CallbackReturn(IntEnum):
    """Result of a transition callback. The value is the id in lifecycle_msgs/Transition."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    @property
    def label(self) -> str:
        """Label of the transition that this result takes."""
        return f"transition_{self.name.lower()}"


@frozen
class Transition:
    """An edge of the machine."""

    id: int
    label: str
    start: State
    goal: State

    @property
    def is_public(self) -> bool:
        """Whether it may be requested. The others are taken by the result of a callback."""
        return self.id < 10


RAISE_ERROR_LABEL = "raise_error"
"""Label of our extension, with id 0: from a primary state to errorprocessing."""

_SUCCESS, _FAILURE, _ERROR = (answer.label for answer in CallbackReturn)

TRANSITIONS: tuple[Transition, ...] = (
    Transition(1, "configure", State.UNCONFIGURED, State.CONFIGURING),
    Transition(10, _SUCCESS, State.CONFIGURING, State.INACTIVE),
    Transition(11, _FAILURE, State.CONFIGURING, State.UNCONFIGURED),
    Transition(12, _ERROR, State.CONFIGURING, State.ERRORPROCESSING),
    Transition(2, "cleanup", State.INACTIVE, State.CLEANINGUP),
    Transition(20, _SUCCESS, State.CLEANINGUP, State.UNCONFIGURED),
    Transition(21, _FAILURE, State.CLEANINGUP, State.INACTIVE),
    Transition(22, _ERROR, State.CLEANINGUP, State.ERRORPROCESSING),
    Transition(3, "activate", State.INACTIVE, State.ACTIVATING),
    Transition(30, _SUCCESS, State.ACTIVATING, State.ACTIVE),
    Transition(31, _FAILURE, State.ACTIVATING, State.INACTIVE),
    Transition(32, _ERROR, State.ACTIVATING, State.ERRORPROCESSING),
    Transition(4, "deactivate", State.ACTIVE, State.DEACTIVATING),
    Transition(40, _SUCCESS, State.DEACTIVATING, State.INACTIVE),
    Transition(41, _FAILURE, State.DEACTIVATING, State.ACTIVE),
    Transition(42, _ERROR, State.DEACTIVATING, State.ERRORPROCESSING),
    Transition(5, "shutdown", State.UNCONFIGURED, State.SHUTTINGDOWN),
    Transition(6, "shutdown", State.INACTIVE, State.SHUTTINGDOWN),
    Transition(7, "shutdown", State.ACTIVE, State.SHUTTINGDOWN),
    Transition(50, _SUCCESS, State.SHUTTINGDOWN, State.FINALIZED),
    Transition(51, _FAILURE, State.SHUTTINGDOWN, State.FINALIZED),
    Transition(52, _ERROR, State.SHUTTINGDOWN, State.ERRORPROCESSING),
    Transition(60, _SUCCESS, State.ERRORPROCESSING, State.UNCONFIGURED),
    Transition(61, _FAILURE, State.ERRORPROCESSING, State.FINALIZED),
    Transition(62, _ERROR, State.ERRORPROCESSING, State.FINALIZED),
)
"""All transitions, in rcl's order of registration (which `ros2 lifecycle list -a` prints)."""

CALLBACKS: dict[State, str] = {
    State.CONFIGURING: "on_configure",
    State.CLEANINGUP: "on_cleanup",
    State.SHUTTINGDOWN: "on_shutdown",
    State.ACTIVATING: "on_activate",
    State.DEACTIVATING: "on_deactivate",
    State.ERRORPROCESSING: "on_error",
}
"""Callback that each transition state runs."""


def starting_at(state: State) -> tuple[Transition, ...]:
    """Return the transitions that start at `state`, in order of registration."""
    return tuple(transition for transition in TRANSITIONS if transition.start is state)
