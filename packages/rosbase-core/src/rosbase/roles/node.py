"""The node: communication and caching, with a manager or standalone, with the same code."""

import sys
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from attrs import evolve

from rosbase.clock import Clock
from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.node_connection import NodeConnection, Publisher, Subscription, Timer
from rosbase.contracts.parameter_store import OnSetParameters
from rosbase.contracts.recording import Recording, RecordOptions
from rosbase.contracts.services import Client, Service, ServiceCallback, ServiceType
from rosbase.control.programs import may_be_offered, offered
from rosbase.errors import ParameterError
from rosbase.parameters import (
    Parameter,
    ParameterSpec,
    ParameterValue,
    SetParametersResult,
    check_value,
)
from rosbase.parameters.given import are_inherited, given_parameters
from rosbase.qos import QoSProfile
from rosbase.roles.callables import check_callback
from rosbase.roles.connection import connect, lone_node_name
from rosbase.roles.construction import Constructed, constructor
from rosbase.roles.context import Component, ManagerContext
from rosbase.roles.keywords import warn_of_untaken
from rosbase.roles.latest import Latest
from rosbase.roles.program import NodeProgram
from rosbase.roles.recording import (
    end_recording,
    follow_stops,
    has_no_signals,
    note_interruption,
    open_program,
    recorded,
)
from rosbase.roles.shutdown import is_wish, run_steps
from rosbase.runtime.stopping import StopSignals, limit_real_time, stop_on_signals

__all__ = ["BaseNode"]

MessageT = TypeVar("MessageT")
RequestT = TypeVar("RequestT")
ResponseT = TypeVar("ResponseT")
ValueT = TypeVar("ValueT", bound=ParameterValue)

_NS_PER_S = 1_000_000_000


class BaseNode(Constructed, Component):
    """Base class of nodes: publishes, subscribes, and caches data for handlers and agents.

    With a manager it uses the manager's connection. Without a manager it opens its own, and
    `start_spin_standalone()` runs it.
    """

    _plain_methods: ClassVar[tuple[str, ...]] = ("release_resources", "destroy_node")
    _is_lifecycle: ClassVar[bool] = False
    """Whether other programs see it as a node of its own name."""
    _recording: Recording | None = None
    """Recording of a standalone node."""
    _is_running = False
    """Whether a standalone node is spun, and cleans up after itself."""
    _connection: NodeConnection
    """Connection for its own topics, timers and parameters."""

    @constructor
    def __init__(
        self,
        manager: ManagerContext | None = None,
        *args: Any,
        node_name: str | None = None,
        backend: str | Backend | None = None,
        custom_logger: Callable[[str], Any] | None = None,
        parameter_defaults: Mapping[str, ParameterValue] | None = None,
        control: bool = True,
        record: str | Path | RecordOptions | None = None,
        **kwargs: Any,
    ) -> None:
        """Attach to the manager, or open a connection.

        Args:
            manager: The manager that registers this node, if one does.
            args: Arguments that the manager forwards; ignored here.
            node_name: The name of a standalone node; by default made from its class.
            backend: The backend of a standalone node, by name or ready made.
            custom_logger: A class that a standalone node calls with its name for its logger.
            parameter_defaults: Values that replace the defaults of its parameters, by the name of
                the parameter. With the name of a node in front, as in `camera.fps`, one is for
                that node of a manager alone.
            control: Whether programs of this user, such as `rosbase topic list`, can look at a
                standalone node and operate it while it runs. `ROSBASE_CONTROL=off` turns it off.
            record: File to which a standalone node is recorded, or options with such a file; by
                default what `rosbase run --record` says. It needs rosbase-mcap.
            kwargs: Arguments that the manager forwards; ignored here. A standalone node warns of
                those that its class does not name.
        """
        super().__init__(manager)
        self._stop_requested = False
        self._parameter_defaults = parameter_defaults or {}
        if "_connection" in self.__dict__:
            # A base class is initialised twice, as in a diamond of old style.
            return
        if manager is not None:
            self._backend = manager.backend
            self._connection, self.logger = connect(
                manager, self._key, is_lifecycle=self._is_lifecycle
            )
            return
        name = self._program_name = node_name or lone_node_name(self)
        options = BackendOptions(node_name=name)
        opened = open_program(record, backend, options, custom_logger)
        self._backend, self.logger, self._recording = opened
        follow_stops(self._backend, self._stop_now)
        self._connection = self._backend
        self._program = NodeProgram(self)
        self._is_offered = may_be_offered(self._backend, wanted=control)
        warn_of_untaken(kwargs, [type(self)], BaseNode, self.logger.warning)

    def create_publisher(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile = 10
    ) -> Publisher[MessageT]:
        """Create a publisher of messages of that type, with that depth or profile."""
        return self._connection.create_publisher(msg_type, topic, qos_profile)

    def create_subscription(
        self,
        msg_type: type[MessageT],
        topic: str,
        callback: Callable[[MessageT], object],
        qos_profile: int | QoSProfile = 10,
    ) -> Subscription[MessageT]:
        """Create a subscription: `callback(message)` is called on the main-loop thread.

        Up to `depth` messages wait for it; older ones are dropped and counted.

        Raises:
            TypeError: The callback cannot be called, or is async or a generator.
        """
        check_callback(callback, f"the subscription to {topic}")
        return self._connection.create_subscription(msg_type, topic, callback, qos_profile)

    def create_service(
        self,
        srv_type: ServiceType[RequestT, ResponseT],
        srv_name: str,
        callback: ServiceCallback[RequestT, ResponseT],
    ) -> Service:
        """Create a service: `callback` answers its requests, on the main-loop thread.

        It is called even while that thread waits for the answer of another service. If it raises
        an exception, the log has it, and the caller gets a `ServiceFailedError`.

        Args:
            srv_type: A class with the classes `Request` and `Response`.
            srv_name: Its name, resolved as a topic's.
            callback: `callback(request, response)` as in rclpy, or `callback(request)`. It returns
                a `Response`.

        Raises:
            TypeError: The callback cannot be called, or is async or a generator.
        """
        check_callback(callback, f"the service {srv_name}")
        return self._connection.create_service(srv_type, srv_name, callback)

    def create_client(
        self, srv_type: ServiceType[RequestT, ResponseT], srv_name: str
    ) -> Client[RequestT, ResponseT]:
        """Create a client of a service: `client.call(request)` returns the answer."""
        return self._connection.create_client(srv_type, srv_name)

    def create_timer(self, timer_period_sec: float, callback: Callable[[], object]) -> Timer:
        """Create a timer: `callback()` is called on the main-loop thread, once per period.

        Raises:
            TypeError: The callback cannot be called, or is async or a generator.
        """
        check_callback(callback, "a timer")
        return self._connection.create_timer(timer_period_sec, callback)

    def latest(
        self, msg_type: type[MessageT], topic: str, qos_profile: int | QoSProfile = 1
    ) -> Latest[MessageT]:
        """Subscribe to a topic, and return an object that holds its latest message.

        Args:
            msg_type: The class of its messages.
            topic: Its name.
            qos_profile: As for a subscription. The latest message needs a depth of 1 only.
        """
        return Latest(
            lambda keep: self.create_subscription(msg_type, topic, keep, qos_profile),
            self._connection.timer_now_ns,
        )

    def destroy_publisher(self, publisher: Publisher[Any]) -> None:
        """Destroy a publisher."""
        self._connection.destroy_publisher(publisher)

    def destroy_subscription(self, subscription: Subscription[Any]) -> None:
        """Destroy a subscription: its callback is not called again."""
        self._connection.destroy_subscription(subscription)

    def destroy_service(self, service: Service) -> None:
        """Destroy a service: requests that wait for it fail."""
        self._connection.destroy_service(service)

    def destroy_client(self, client: Client[Any, Any]) -> None:
        """Destroy a client: its calls fail."""
        self._connection.destroy_client(client)

    def destroy_timer(self, timer: Timer) -> None:
        """Destroy a timer."""
        self._connection.destroy_timer(timer)

    def get_clock(self) -> Clock:
        """Return the clock: `get_clock().now()` is a stamp."""
        return self._connection.clock

    def declare_parameter(
        self, name: str, value: ValueT, spec: ParameterSpec | None = None
    ) -> Parameter[ValueT]:
        """Declare a parameter, and return it with its value as set from outside.

        Args:
            name: Its name. Other programs see it with the name of the node in front, such as
                `camera.fps`, if the node shares the connection of its manager.
            value: Its default, which also says its type, and that of the
                value returned. `parameter_defaults` may replace it.
            spec: More about it, such as its range; its name and default are those above.

        Raises:
            ParameterError: It exists already, or was set to an invalid value, or only a lifecycle
                node can have it.
        """
        spec = evolve(spec, name=name, default=value) if spec else ParameterSpec(name, value)
        if spec.change_time != "always" and not self._is_lifecycle:
            raise ParameterError(
                f"parameter {spec.name} has change_time {spec.change_time!r}, which only a"
                " lifecycle node can have"
            )
        return self._connection.declare_parameter(self._as_given(spec))

    def get_parameter(self, name: str) -> Parameter[Any]:
        """Return a declared parameter; its `value` is the current one.

        Raises:
            ParameterError: It has not been declared.
        """
        return self._connection.get_parameter(name)

    def has_parameter(self, name: str) -> bool:
        """Return whether the node has declared the parameter."""
        try:
            self.get_parameter(name)
        except ParameterError:
            return False
        return True

    def set_parameter(self, name: str, value: ParameterValue) -> SetParametersResult:
        """Set one parameter; return whether it was set, and the reason if not."""
        return self.set_parameters([Parameter(name, value)])

    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none. Call it on the main-loop thread.

        Returns:
            Whether they were set, and the reason if not. A parameter may be undeclared or
            read-only, its value may have another type, or a callback may refuse it.
        """
        return self._connection.set_parameters(parameters)

    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback(parameters)` on the main-loop thread before parameters are set.

        The callback returns a `SetParametersResult`. Refused parameters keep their values,
        and the caller that sets them gets the reason.
        """
        check_callback(callback, "add_on_set_parameters_callback")
        self._connection.add_on_set_parameters_callback(callback)

    def add_post_set_parameters_callback(
        self, callback: Callable[[list[Parameter[Any]]], object]
    ) -> None:
        """Call `callback(parameters)` on the main-loop thread, soon after parameters were set."""
        check_callback(callback, "add_post_set_parameters_callback")
        self._connection.add_post_set_parameters_callback(callback)

    def start_spin_standalone(self) -> None:
        """Run a standalone node until SIGINT or SIGTERM, then clean up after it.

        Raises:
            RuntimeError: The node belongs to a manager, which does the spinning.
        """
        if self.manager is not None:
            raise RuntimeError("a node with a manager is run by the manager")
        executor = self._backend.executor
        if has_no_signals(self._backend):
            # The signals of a test are its runner's.
            with limit_real_time(executor.clock, executor.call_urgently):
                self._run(None)
            return
        request_stop = partial(executor.in_signal, self._request_stop)
        with (
            stop_on_signals(request_stop, executor.call_urgently) as stop,
            offered(self._program if self._is_offered else None, self.logger),
        ):
            self._run(stop)

    def request_stop(self) -> None:
        """End the spinning of a standalone node, or the manager's main loop.

        Call it from any thread.
        """
        if self.manager is not None:
            self.manager.request_stop()
        else:
            self._request_stop()

    def release_resources(self) -> None:
        """Release files, threads and devices. Called when the node ends."""

    def destroy_node(self) -> None:
        """Close a standalone node's own connection. Ignored if it is closed, or with a manager."""
        if self.manager is None:
            self._backend.close()
            if not self._is_running:
                end_recording(self._recording, self._backend, None)

    def _as_given(self, spec: ParameterSpec) -> ParameterSpec:
        """Return the declaration with the default that the program or its user gives instead."""
        own, defaults = f"{self._key}.{spec.name}", self._parameter_defaults
        if own in defaults or spec.name in defaults:
            default = defaults[own] if own in defaults else defaults[spec.name]
            spec = evolve(spec, default=check_value(spec, default))
        value = given_parameters().value_for(spec, *self._names_outside())
        return spec if value is None else evolve(spec, default=value)

    def _names_outside(self) -> tuple[list[str], list[str]]:
        """Return the names by which users know this node and its manager."""
        backend_name = self._backend.node_name
        if self.manager is None:
            return [self._program_name, backend_name], []
        registration = getattr(self.manager, "_registration", None)
        of_manager = [registration.node_name, backend_name] if registration else [backend_name]
        if not self._key:
            return of_manager, []
        is_node = self._is_lifecycle
        return [self._key, self._connection.node_name] if is_node else [self._key], of_manager

    @property
    def _label(self) -> str:
        """Name in the log: its key at the manager, or the name that others see."""
        is_alone = self.__dict__.get("manager") is None and hasattr(self, "_backend")
        return self._backend.node_name if is_alone else super()._label

    def _repr_parts(self) -> list[str]:
        is_alone = self.__dict__.get("manager") is None and hasattr(self, "_backend")
        return [repr(self._backend.node_name)] if is_alone else super()._repr_parts()

    def _end_program(self) -> None:
        if hasattr(self, "_backend"):
            self._backend.end_run()

    def _abandon(self) -> None:
        """Release the resources of a constructor that failed."""
        if self.__dict__.get("manager") is None and hasattr(self, "_backend"):
            self._backend.close()
            end_recording(self._recording, self._backend, sys.exc_info()[1])

    def _run(self, stop: StopSignals | None) -> None:
        self._is_running = True
        with recorded(self._recording, self._backend):
            self._run_through(stop)

    def _run_through(self, stop: StopSignals | None) -> None:
        try:
            self._backend.executor.begin(lambda: self._stop_requested)
            self._backend.begin_run(self._request_stop)
            self._program.phase = "bringing up"
            self._begin()
            self._name_undeclared()
            self._program.phase = "running"
            while not self._stop_requested:
                deadline_ns = self._backend.clock.monotonic_ns() + _NS_PER_S
                self._backend.spin_until(deadline_ns, lambda: self._stop_requested)
        except BaseException as error:
            note_interruption(self._backend, error)
            failure = self._shut_down(stop)
            if not is_wish(error, stop):
                raise
        else:
            failure = self._shut_down(stop)
        if failure is not None:
            raise failure

    def _name_undeclared(self) -> None:
        """Warn of parameters from outside that this standalone node has not declared."""
        is_child = are_inherited()
        if not is_child or self._program_name:
            for line in given_parameters().unused(only_for=self._program_name if is_child else ""):
                self.logger.warning(line)

    def _begin(self) -> None:
        """Prepare a standalone node before it is spun."""

    def _end(self) -> None:
        """Clean up a standalone node after it was spun."""

    def _shut_down(self, stop: StopSignals | None) -> BaseException | None:
        self._program.phase = "stopping"
        self._backend.executor.begin_clean_up()
        return run_steps(
            [
                ("lifecycle", self._end),
                ("release_resources", self.release_resources),
                ("destroy_node", self.destroy_node),
            ],
            self.logger,
            stop,
            ("the backend's world", self._backend.end_run),
        )

    def _request_stop(self) -> None:
        self._backend.executor.stop_soon(self._stop_now)

    def _stop_now(self) -> None:
        self._stop_requested = True
        self._backend.call_soon(lambda: None)
