"""rosbase calls plain functions with certain arguments, and awaits nothing."""

from rosbase import BaseHandlers, BaseNode, CallbackReturn, LifecycleNode, State
from rosbase.fsm import Machine, Transition
from rosbase.messages import Imu


class Base(BaseNode):
    def begin(self) -> None:
        self.create_timer(0.1, self.tick)
        self.create_timer(0.1, self.turn)  # fails: a timer gives no argument
        self.create_timer("0.1", self.tick)  # fails: seconds are a number
        self.create_subscription(Imu, "imu/data", self.tick)  # fails: it takes no message

    def tick(self) -> None: ...

    def turn(self, angle: float) -> None: ...


class AsyncHandlers(BaseHandlers):
    async def handle(self) -> None: ...  # fails: a coroutine


class Camera(LifecycleNode):
    def on_configure(self, previous_state: State) -> bool:  # fails: no CallbackReturn
        return True

    async def on_activate(self, previous_state: State) -> CallbackReturn:  # fails: a coroutine
        return CallbackReturn.SUCCESS


class Task(BaseHandlers):
    def begin(self) -> None:
        rows = [Transition("a", "b", when=self.is_due)]
        Machine("a", rows, holder=self)
        Machine("a", rows, holder=Base())  # fails: a node has no state
        Transition("a", "b", when="due")  # fails: a guard is a function

    def is_due(self) -> bool:
        return self.timestamp > 5
