"""A node with the managed lifecycle of ROS 2."""

import threading
from collections.abc import Callable
from typing import Any, Literal, TypeAlias, TypeVar

from rosbase.contracts.backend import Publisher
from rosbase.errors import TransitionNotAvailableError
from rosbase.lifecycle import CALLBACKS, CallbackReturn, Machine, State, Transition, TransitionEvent
from rosbase.qos import QoSProfile
from rosbase.roles.node import BaseNode

__all__ = ["Autostart", "LifecycleNode", "LifecyclePublisher"]

Autostart: TypeAlias = Literal["none", "configure", "activate"]
"""How far a manager brings a lifecycle node up by itself."""

MessageT = TypeVar("MessageT")

_TRANSITION_PATIENCE_S = 5.0


class LifecyclePublisher:
    """A publisher that sends only while its node is active."""

    __slots__ = ("_publisher", "_send", "is_enabled")

    def __init__(self, publisher: Publisher) -> None:
        self._publisher = publisher
        self._send = publisher.publish
        self.is_enabled = False
        """Whether the node is active."""

    @property
    def topic(self) -> str:
        """The full name of the topic."""
        return self._publisher.topic

    @property
    def inner(self) -> Publisher:
        """The backend's publisher."""
        return self._publisher

    def publish(self, message: Any) -> bool:
        """Hand the message on if the node is active; return whether it was, and the message went.

        Raises:
            TypeError: As `rosbase.Publisher.publish`.
            ValueError: As `rosbase.Publisher.publish`.
        """
        return self.is_enabled and self._send(message) is not False


class LifecycleNode(BaseNode):
    """A node that is configured, activated, deactivated and cleaned up on request.

    Override the `on_...` callbacks. Each is given the primary state that the node was in,
    and answers SUCCESS, FAILURE (back to where it was) or ERROR (`on_error` follows).
    Whoever answers FAILURE leaves the reason in `last_error`, to be logged. Raising is
    ERROR. One transition runs at a time; requests for another, or for one that does not
    start at the present state, are refused and change nothing.

    Publishers send only while the node is active. Subscriptions and timers run in every state,
    as in rclpy: a callback that should do nothing while the node is inactive looks at
    `get_state()`, or is created in `on_activate` and destroyed in `on_deactivate`.
    """

    autostart: Autostart = "none"
    """How far the manager brings this node up by itself."""

    def __init__(self, manager: Any = None, *args: Any, **kwargs: Any) -> None:
        """As every node; starts unconfigured."""
        super().__init__(manager, *args, **kwargs)
        self.last_error: BaseException | None = None
        """What went wrong the last time: raised by a callback, left by one that answered
        FAILURE, or given to `raise_error`."""
        self._machine = Machine()
        self._transition_lock = threading.Lock()
        self._transition_thread: int | None = None
        self._transition_since_ns: int | None = None
        self._gated: list[LifecyclePublisher] = []
        self._interrupt: BaseException | None = None
        self._listeners: list[Callable[[TransitionEvent], object]] = []
        self._backend.expose_lifecycle(self)

    # What users override.

    def on_configure(self, previous_state: State) -> CallbackReturn:
        """Called on configure. Read parameters and take what the node needs."""
        return CallbackReturn.SUCCESS

    def on_activate(self, previous_state: State) -> CallbackReturn:
        """Called on activate. Start the work; publishers are enabled on SUCCESS."""
        return CallbackReturn.SUCCESS

    def on_deactivate(self, previous_state: State) -> CallbackReturn:
        """Called on deactivate, publishers being disabled already. Stop the work."""
        return CallbackReturn.SUCCESS

    def on_cleanup(self, previous_state: State) -> CallbackReturn:
        """Called on cleanup. Give back what `on_configure` took."""
        return CallbackReturn.SUCCESS

    def on_shutdown(self, previous_state: State) -> CallbackReturn:
        """Called on shutdown, from any of the other states. Stop, and give everything back."""
        return CallbackReturn.SUCCESS

    def on_error(self, previous_state: State) -> CallbackReturn:
        """Called after ERROR. Undo everything: SUCCESS means unconfigured, else finalized."""
        return CallbackReturn.SUCCESS

    # What users call.

    def get_state(self) -> State:
        """Where the lifecycle is, also while a transition runs."""
        return self._machine.state

    def describe_transition(self) -> str:
        """Say which transition runs, such as `busy: configuring since 3 s`; empty if none does."""
        since_ns = self._transition_since_ns
        if since_ns is None:
            return ""
        seconds = (self._backend.clock.monotonic_ns() - since_ns) / 1e9
        return f"busy: {self._machine.state.label} since {seconds:.0f} s"

    def get_available_transitions(self) -> tuple[Transition, ...]:
        """The transitions that start at the present state."""
        return self._machine.available_transitions()

    def add_transition_listener(self, listener: Callable[[TransitionEvent], object]) -> None:
        """Has `listener(event)` called after each step, on the thread that takes it."""
        self._listeners.append(listener)

    def trigger_configure(self) -> CallbackReturn:
        """unconfigured -> inactive. As all of these, it answers what the callback did.

        Raises:
            TransitionNotAvailableError: Not from this state, or another one is under way.
        """
        return self.request_transition(label="configure")

    def trigger_activate(self) -> CallbackReturn:
        """inactive -> active."""
        return self.request_transition(label="activate")

    def trigger_deactivate(self) -> CallbackReturn:
        """active -> inactive."""
        return self.request_transition(label="deactivate")

    def trigger_cleanup(self) -> CallbackReturn:
        """inactive -> unconfigured."""
        return self.request_transition(label="cleanup")

    def trigger_shutdown(self) -> CallbackReturn:
        """unconfigured, inactive or active -> finalized."""
        return self.request_transition(label="shutdown")

    def request_transition(self, transition_id: int = 0, label: str = "") -> CallbackReturn:
        """Runs the transition of that label, or else of that id, with its callback.

        Returns:
            What the callback answered. ERROR stays ERROR when `on_error` has mended it.

        Raises:
            TransitionNotAvailableError: Not from this state, or another one is under way.
        """
        return self._drive(lambda: self._machine.request(transition_id, label))

    def bring_up(self, stopping: Callable[[], object] = lambda: False) -> bool:
        """Brings the node as far as its `autostart` says; tells whether it got there.

        It goes no farther once `stopping` says so.

        Raises:
            ValueError: `autostart` says something else.
        """
        labels = {"none": (), "configure": ("configure",), "activate": ("configure", "activate")}
        if self.autostart not in labels:
            choices = ", ".join(labels)
            raise ValueError(
                f"autostart of {type(self).__name__} is one of {choices}, not {self.autostart!r}"
            )
        for label in labels[self.autostart]:
            if not any(t.label == label for t in self.get_available_transitions()):
                # It has been brought so far, or farther, already.
                continue
            if stopping():
                return False
            if self.request_transition(label=label) is not CallbackReturn.SUCCESS:
                return False
        return True

    def take_down(self, *, finalize: bool) -> None:
        """Deactivates and cleans the node up, and with `finalize` shuts it down.

        Every step is attempted. What ends the program is raised at the end. A transition that
        runs on another thread has a few seconds to come to its end first.
        """
        if self._transition_thread != threading.get_ident():
            if self._transition_lock.acquire(timeout=_TRANSITION_PATIENCE_S):
                self._transition_lock.release()
            else:
                label = self._machine.state.label
                self.logger.error(
                    f"{self._label} is still {label} after {_TRANSITION_PATIENCE_S:g} s"
                )
        steps = ((State.ACTIVE, "deactivate"), (State.INACTIVE, "cleanup"))
        failure: BaseException | None = None
        for state, label in (*steps, (None, "shutdown")):
            due = self._machine.state is state or (state is None and finalize)
            if not due or self._machine.state is State.FINALIZED:
                continue
            try:
                self.request_transition(label=label)
            except BaseException as error:
                failure = failure or error
        if failure is not None:
            raise failure

    def raise_error(self, error: BaseException) -> CallbackReturn:
        """Reports a fault outside of any transition: `on_error` runs, as after ERROR.

        Returns:
            What `on_error` answered.

        Raises:
            TransitionNotAvailableError: The node is finalized, or a transition is under way.
        """

        def begin() -> TransitionEvent:
            previous = self._machine.state
            event = self._machine.raise_error()
            self.last_error = error
            self.logger.error(f"{self._prefix}error in {previous.label}: {_described(error)}")
            return event

        return self._drive(begin)

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile = 10
    ) -> LifecyclePublisher:
        """A publisher that sends only while the node is active."""
        publisher = LifecyclePublisher(super().create_publisher(msg_type, topic, qos_profile))
        publisher.is_enabled = self._machine.state is State.ACTIVE
        self._gated.append(publisher)
        return publisher

    def destroy_publisher(self, publisher: Publisher) -> None:
        """Ends a publisher."""
        if isinstance(publisher, LifecyclePublisher):
            publisher.is_enabled = False
            if publisher in self._gated:
                self._gated.remove(publisher)
            publisher = publisher.inner
        super().destroy_publisher(publisher)

    # How a lone node and a transition run.

    def _repr_parts(self) -> list[str]:
        is_ready = hasattr(self, "_machine")
        return [*super()._repr_parts(), *([self.get_state().label] if is_ready else [])]

    def _begin(self) -> None:
        self.bring_up()

    def _end(self) -> None:
        self.take_down(finalize=True)

    @property
    def _prefix(self) -> str:
        """Who speaks, where the logger is the manager's."""
        is_managers = self.manager is not None and self._label != self.manager.backend.node_name
        return f"{self._label}: " if is_managers else ""

    def _drive(self, begin: Callable[[], TransitionEvent]) -> CallbackReturn:
        if not self._transition_lock.acquire(blocking=False):
            raise TransitionNotAvailableError(self.describe_transition() or "busy")
        self._transition_thread = threading.get_ident()
        self._transition_since_ns = self._backend.clock.monotonic_ns()
        # What ends the program is passed on once the machine has come to rest.
        self._interrupt = None
        known_error = self.last_error
        try:
            event = begin()
            self._note(event)
            answer = self._call_back()
            self._note(self._machine.finish(answer))
            if answer is CallbackReturn.FAILURE:
                reason = self._reason(known_error)
                state = self._machine.state.label
                self.logger.error(
                    f"{self._prefix}{event.transition.label} failed, now {state}: {reason}"
                )
            if self._machine.state is State.ERRORPROCESSING:
                self._note(self._machine.finish(self._call_back()))
            interrupt = self._interrupt
        finally:
            self._transition_thread = self._transition_since_ns = None
            self._transition_lock.release()
        if interrupt is not None:
            raise interrupt
        return answer

    def _call_back(self) -> CallbackReturn:
        """Runs the callback of the present state; gives its answer."""
        name, known_error = CALLBACKS[self._machine.state], self.last_error
        try:
            answer = getattr(self, name)(self._machine.previous_state)
        except BaseException as error:
            self.last_error = error
            self._report(name, error)
            return CallbackReturn.ERROR
        if answer is CallbackReturn.ERROR:
            self.logger.error(f"{self._prefix}{name} answered ERROR: {self._reason(known_error)}")
        if isinstance(answer, CallbackReturn):
            return answer
        self.last_error = TypeError(f"{name} must return a CallbackReturn, not {answer!r}")
        self.logger.error(f"{self._prefix}{self.last_error}")
        return CallbackReturn.ERROR

    def _reason(self, known_error: BaseException | None) -> object:
        """What a callback left in `last_error`."""
        is_new = self.last_error is not known_error and self.last_error is not None
        return self.last_error if is_new else "no reason (set last_error to give one)"

    def _note(self, event: TransitionEvent) -> None:
        is_active = event.goal is State.ACTIVE
        for publisher in self._gated:
            publisher.is_enabled = is_active
        for listener in self._listeners:
            try:
                listener(event)
            except BaseException as error:
                self._report("a transition listener", error)

    def _report(self, who: str, error: BaseException) -> None:
        if isinstance(error, Exception):
            self.logger.error(f"{self._prefix}{who} raised {_described(error)}", exc_info=error)
        else:
            self._interrupt = self._interrupt or error


def _described(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"
