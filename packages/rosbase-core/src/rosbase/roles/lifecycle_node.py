"""A node with the managed lifecycle of ROS 2."""

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any, ClassVar, Literal, TypeAlias, TypeVar

from attrs import evolve

from rosbase.contracts.backend import Publisher
from rosbase.contracts.parameter_store import OnSetParameters, refused
from rosbase.lifecycle import CALLBACKS, CallbackReturn, Machine, State, Transition, TransitionEvent
from rosbase.parameters import Parameter, ParameterSpec, ParameterValue, SetParametersResult
from rosbase.qos import QoSProfile
from rosbase.roles.callables import check_callback
from rosbase.roles.change_times import refusal
from rosbase.roles.context import ManagerContext
from rosbase.roles.lifecycle_publisher import LifecyclePublisher
from rosbase.roles.node import BaseNode
from rosbase.roles.set_by_constructor import must_call_base
from rosbase.roles.transitions import Transitions

__all__ = ["Autostart", "LifecycleNode"]

Autostart: TypeAlias = Literal["none", "configure", "activate"]
"""How far a manager brings a lifecycle node up by itself."""

MessageT = TypeVar("MessageT")
ValueT = TypeVar("ValueT", bound=ParameterValue)

_TRANSITION_PATIENCE_S = 5.0


class LifecycleNode(BaseNode):
    """A node that is configured, activated, deactivated and cleaned up on request.

    Override the `on_...` callbacks. Each receives the previous primary state. It returns
    SUCCESS, FAILURE (back to the previous state) or ERROR (`on_error` follows). A callback
    that returns FAILURE puts the reason in `last_error`, to be logged. An exception counts as
    ERROR. One transition runs at a time. Requests for another, or for one that does not start
    at the current state, are refused and change nothing.

    Publishers send only while the node is active. Subscriptions and timers run in every state,
    as in rclpy. If a callback should do nothing while the node is inactive, check
    `get_state()` in it. Or create it in `on_activate` and destroy it in `on_deactivate`.
    """

    _is_lifecycle: ClassVar[bool] = True
    autostart: Autostart = "none"
    """How far the manager brings this node up by itself."""
    _plain_methods: ClassVar[tuple[str, ...]] = (*BaseNode._plain_methods, *CALLBACKS.values())

    def __init__(self, manager: ManagerContext | None = None, *args: Any, **kwargs: Any) -> None:
        """Start unconfigured. The arguments are those of `BaseNode`."""
        super().__init__(manager, *args, **kwargs)
        # Parameters that may not always change, by name.
        self._limited: dict[str, ParameterSpec] = {}
        self.last_error: BaseException | None = None
        """Reason of the last failure.

        It is an exception of a callback, the text left by one that returned FAILURE, or
        the text given to `raise_error`.
        """
        self._machine = Machine()
        self._transitions = Transitions(self, self._machine, self._backend.clock)
        self._gated: list[LifecyclePublisher[Any]] = []
        # The first one, so that others find the publishers as they are in the new state.
        self._transitions.add_listener(self._gate)
        self._connection.expose_lifecycle(self)

    # What users override.

    def on_configure(self, previous_state: State) -> CallbackReturn:
        """Read parameters and acquire resources. Called on configure."""
        return CallbackReturn.SUCCESS

    def on_activate(self, previous_state: State) -> CallbackReturn:
        """Start the work. Called on activate; publishers are enabled on SUCCESS."""
        return CallbackReturn.SUCCESS

    def on_deactivate(self, previous_state: State) -> CallbackReturn:
        """Stop the work. Called on deactivate, when publishers are already disabled."""
        return CallbackReturn.SUCCESS

    def on_cleanup(self, previous_state: State) -> CallbackReturn:
        """Release what `on_configure` acquired. Called on cleanup."""
        return CallbackReturn.SUCCESS

    def on_shutdown(self, previous_state: State) -> CallbackReturn:
        """Stop, and release everything. Called on shutdown, from any of the other states."""
        return CallbackReturn.SUCCESS

    def on_error(self, previous_state: State) -> CallbackReturn:
        """Undo everything: SUCCESS leads to unconfigured, else finalized. Called after ERROR."""
        return CallbackReturn.SUCCESS

    # What users call.

    def declare_parameter(
        self, name: str, value: ValueT, spec: ParameterSpec | None = None
    ) -> Parameter[ValueT]:
        """Declare a parameter as `BaseNode` does; its `change_time` limits when it may change."""
        if spec is not None and spec.change_time != "always":
            if not self._limited:
                # Before it can be set.
                super().add_on_set_parameters_callback(self._judge_times)
            self._limited[name] = evolve(spec, name=name)
        return super().declare_parameter(name, value, spec)

    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback(parameters)` as `BaseNode` does, unless one of them may not change now."""
        check_callback(callback, "add_on_set_parameters_callback")

        @wraps(callback)
        def ask_in_time(parameters: list[Parameter[Any]]) -> Any:
            judged = self._judge_times(parameters)
            return callback(parameters) if judged.successful else judged

        super().add_on_set_parameters_callback(ask_in_time)

    def get_state(self) -> State:
        """Return the current state of the lifecycle, also while a transition runs."""
        return self._machine.state

    def describe_transition(self) -> str:
        """Say which transition runs, such as `busy: configuring since 3 s`; empty if none does."""
        return self._transitions.describe()

    def get_available_transitions(self) -> tuple[Transition, ...]:
        """Return the transitions that start at the current state."""
        return self._machine.available_transitions()

    def add_transition_listener(self, listener: Callable[[TransitionEvent], object]) -> None:
        """Call `listener(event)` after each step, on the thread that takes it."""
        self._transitions.add_listener(listener)

    def trigger_configure(self) -> CallbackReturn:
        """Run unconfigured -> inactive. Like all of these, return the result of the callback.

        Raises:
            TransitionNotAvailableError: It does not start at this state, or another one is
                running.
        """
        return self.request_transition(label="configure")

    def trigger_activate(self) -> CallbackReturn:
        """Run inactive -> active."""
        return self.request_transition(label="activate")

    def trigger_deactivate(self) -> CallbackReturn:
        """Run active -> inactive."""
        return self.request_transition(label="deactivate")

    def trigger_cleanup(self) -> CallbackReturn:
        """Run inactive -> unconfigured."""
        return self.request_transition(label="cleanup")

    def trigger_shutdown(self) -> CallbackReturn:
        """Run unconfigured, inactive or active -> finalized."""
        return self.request_transition(label="shutdown")

    def request_transition(self, transition_id: int = 0, label: str = "") -> CallbackReturn:
        """Run the transition of that label, or else of that id, with its callback.

        Returns:
            The result of the callback. ERROR stays ERROR even if `on_error` has recovered.

        Raises:
            TransitionNotAvailableError: It does not start at this state, or another one is
                running.
        """
        return self._transitions.request(transition_id, label)

    def bring_up(self, stopping: Callable[[], object] = lambda: False) -> bool:
        """Bring the node as far as its `autostart` says; return whether it got there.

        It goes no further once `stopping` returns true.

        Raises:
            ValueError: `autostart` has another value.
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
        """Deactivate and clean the node up, and with `finalize` shut it down.

        Every step is attempted. An exception that ends the program is raised at the end. A
        transition that runs on another thread has a few seconds to finish first.
        """
        if not self._transitions.wait_for_others(_TRANSITION_PATIENCE_S):
            label = self._machine.state.label
            self.logger.error(f"{self._label} is still {label} after {_TRANSITION_PATIENCE_S:g} s")
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
        """Report a fault outside of any transition: `on_error` runs, as after ERROR.

        Returns:
            The result of `on_error`.

        Raises:
            TransitionNotAvailableError: The node is finalized, or a transition is running.
        """
        return self._transitions.raise_error(error)

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile = 10
    ) -> LifecyclePublisher[MessageT]:
        """Create a publisher that sends only while the node is active."""
        publisher = LifecyclePublisher(super().create_publisher(msg_type, topic, qos_profile))
        publisher.is_enabled = self._machine.state is State.ACTIVE
        self._gated.append(publisher)
        return publisher

    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher."""
        if isinstance(publisher, LifecyclePublisher):
            publisher.is_enabled = False
            if publisher in self._gated:
                self._gated.remove(publisher)
            publisher = publisher.inner
        super().destroy_publisher(publisher)

    # What goes with the state, and how a lone node runs.

    def _judge_times(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Refuse the change of a parameter that may not change in the current state."""
        if self._transitions.is_on_this_thread:
            # A callback of the transition sets what it has found.
            return SetParametersResult(successful=True)
        for parameter in parameters:
            spec = self._limited.get(parameter.name)
            if spec is None or parameter.value == self.get_parameter(spec.name).value:
                continue
            if reason := self.describe_transition() or refusal(spec, self.get_state()):
                return refused(reason)
        return SetParametersResult(successful=True)

    def _gate(self, event: TransitionEvent) -> None:
        """Let the publishers send while the node is active."""
        is_active = event.goal is State.ACTIVE
        for publisher in self._gated:
            publisher.is_enabled = is_active

    def _repr_parts(self) -> list[str]:
        is_ready = hasattr(self, "_machine")
        return [*super()._repr_parts(), *([self.get_state().label] if is_ready else [])]

    def _missing_base(self) -> str:
        is_missing = "_machine" not in self.__dict__
        return must_call_base(self, "manager, *args, **kwargs") if is_missing else ""

    def _begin(self) -> None:
        self.bring_up()

    def _name_undeclared(self) -> None:
        # Parameters may be declared in `on_configure`.
        if self.get_state() is not State.UNCONFIGURED:
            super()._name_undeclared()

    def _end(self) -> None:
        self.take_down(finalize=True)

    @property
    def _prefix(self) -> str:
        """Name of the node in log lines, where the logger is the manager's."""
        is_managers = self.manager is not None and self.logger is self.manager.logger
        is_named = is_managers and self._connection is not self._backend
        return f"{self._label}: " if is_named else ""
