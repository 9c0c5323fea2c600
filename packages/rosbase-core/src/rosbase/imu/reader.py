"""The IMU reader: a lifecycle node that turns the frames of a device into messages."""

from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from rosbase.clock import date_fault
from rosbase.contracts.backend import timer_period_ns
from rosbase.contracts.parameter_store import refused
from rosbase.contracts.transport import Transport, TransportContext, TransportHealth
from rosbase.errors import BackendError, ConfigurationError, TransportError
from rosbase.imu.counts import Counts, CountsSnapshot
from rosbase.imu.diagnostics import Diagnostics
from rosbase.imu.health import Health, HealthLevel
from rosbase.imu.health_monitor import HealthMonitor
from rosbase.imu.names import check_names
from rosbase.imu.outlet import Outlet, Publishers
from rosbase.imu.pipeline import Pipeline
from rosbase.imu.plugin_calls import finished, make_transport
from rosbase.imu.settings import ReaderSettings, read_settings, reader_parameters
from rosbase.lifecycle import CallbackReturn, State
from rosbase.parameters import Parameter, ParameterValue, SetParametersResult
from rosbase.plugins import PluginRegistry, installed_plugins
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase.roles.lifecycle_publisher import LifecyclePublisher
from rosbase.runtime.executor import ExecutorTimer

__all__ = ["DEFAULT_NODE_NAME", "ImuReader"]

MessageT = TypeVar("MessageT")

DEFAULT_NODE_NAME = "lifecycle_manager"

# Ten seconds of a fast IMU, for a subscriber that stalls.
_DEPTH = 10_000
_HEALTH_PERIOD_S = 0.25
_NOT_ACTIVE = Health(HealthLevel.OK, "not active")
_NOTHING: Mapping[str, ParameterValue] = {}


class ImuReader(LifecycleNode):
    """Reads an IMU through any transport and publishes its measurements.

    Topics: `imu/data` for samples with an orientation, `imu/data_raw` for those without
    (REP-145), `imu/mag` for the magnetic field, and `/diagnostics` once a second.

    configure opens the device, activate starts reading, deactivate stops and releases the
    device, cleanup and shutdown release everything. Frames become messages on the transport's
    reader thread. A bad frame is dropped and counted, and the next one goes through.
    """

    def __init__(
        self,
        manager: Any = None,
        *args: Any,
        registry: PluginRegistry | None = None,
        **kwargs: Any,
    ) -> None:
        """Declare the parameters, including those of every installed transport.

        Args:
            manager: The manager, if it has one.
            args: Ignored, as in `BaseNode`.
            registry: Registry of transports and presets; the installed plugins by default.
            kwargs: Passed on to `BaseNode`.

        Raises:
            ConfigurationError: They name something that is not installed, or contradict each
                other.
        """
        super().__init__(manager, *args, **kwargs)
        self._registry = registry or installed_plugins()
        specs = reader_parameters(self._registry)
        self._names = frozenset(spec.name for spec in specs)
        # First: on ROS, tools may set a parameter as soon as it is declared.
        self.add_on_set_parameters_callback(self._judge_change)
        for spec in specs:
            self.declare_parameter(spec.name, spec.default, spec)
        self.autostart = self._value("autostart")
        self._settings = self._read_settings()
        # What cannot be is refused now, not when somebody configures. It touches no device.
        self._make_transport(self._settings)
        self._counts = Counts()
        self._transport: Transport | None = None
        self._publishers: list[LifecyclePublisher[Any]] = []
        self._topics: Publishers | None = None
        self._pipeline: Pipeline | None = None
        self._monitor: HealthMonitor | None = None
        self._monitor_timer: ExecutorTimer | None = None
        self._last_health = _NOT_ACTIVE
        self.add_transition_listener(
            Diagnostics(self, self._connection, self._backend.executor).note
        )

    # What users look at.

    @property
    def counts(self) -> CountsSnapshot:
        """Counts of the frames so far."""
        return self._counts.snapshot(self.transport_health.frame_errors)

    @property
    def transport_health(self) -> TransportHealth:
        """Health of the transport, also after it was closed."""
        return self._transport.health if self._transport else TransportHealth()

    @property
    def health(self) -> Health:
        """Health of the reader, judged four times a second while active."""
        return self._monitor.health if self._monitor else _NOT_ACTIVE

    @property
    def last_health(self) -> Health:
        """Health of the reader now, or when it was last active."""
        return self._last_health if self._monitor is None else self._monitor.health

    def check_health(self) -> Health:
        """Judge the health now, and return it. Call it on the main-loop thread only."""
        if self._monitor is not None:
            self._monitor.look()
        return self.health

    @property
    def settings(self) -> ReaderSettings:
        """Settings from the parameters, as far as they have taken effect."""
        return self._settings

    # The lifecycle.

    def on_configure(self, previous_state: State) -> CallbackReturn:
        """Open the device, or fail with the reason."""
        try:
            settings = self._read_settings()
            transport = self._make_transport(settings)
        except (ConfigurationError, TransportError) as error:
            self.last_error = error
            return CallbackReturn.FAILURE
        # Only now: what it says of the device must not be what nobody has looked at.
        self._settings = settings
        try:
            with finished(settings.transport):
                _open(transport)
            self._topics = Publishers(self._publisher, settings.topic_namespace)
        except BaseException as error:
            # Such as a topic that carries something else already, or a signal: nobody else knows
            # the transport yet.
            transport.close()
            self._release()
            if not isinstance(error, (BackendError, ConfigurationError, TransportError)):
                raise
            self.last_error = error
            return CallbackReturn.FAILURE
        self._replace_transport(transport)
        self._pipeline = self._make_pipeline(settings)
        return CallbackReturn.SUCCESS

    def on_activate(self, previous_state: State) -> CallbackReturn:
        """Start the reader thread, and open the device again if necessary."""
        assert self._transport is not None
        assert self._pipeline is not None
        try:
            self._transport.open()
            # Not before: reaching a device may take longer than it may be silent.
            monitor = self._make_monitor(self._transport, self._pipeline)
            self._transport.start(self._pipeline.take)
        except TransportError as error:
            self._transport.close()
            self.last_error = error
            return CallbackReturn.FAILURE
        self._monitor = monitor
        # On the clock of the machine: a simulation that stands still must not hide a dead device.
        self._monitor_timer = self._backend.executor.create_timer(
            timer_period_ns(_HEALTH_PERIOD_S), monitor.look
        )
        return CallbackReturn.SUCCESS

    def on_deactivate(self, previous_state: State) -> CallbackReturn:
        """End the reader thread and release the device."""
        self._stop_reading()
        return CallbackReturn.SUCCESS

    def on_cleanup(self, previous_state: State) -> CallbackReturn:
        """Release everything."""
        self._release()
        return CallbackReturn.SUCCESS

    def on_shutdown(self, previous_state: State) -> CallbackReturn:
        """Release everything."""
        self._release()
        return CallbackReturn.SUCCESS

    def on_error(self, previous_state: State) -> CallbackReturn:
        """Release everything, so that the node can be configured again."""
        self._release()
        return CallbackReturn.SUCCESS

    def release_resources(self) -> None:
        """Release everything, for a node without a manager."""
        self._release()

    def _judge_change(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Refuse invalid changes; apply at once what can be applied."""
        changed = {
            parameter.name: parameter.value
            for parameter in parameters
            if parameter.name in self._names and parameter.value != self._value(parameter.name)
        }
        state = self.get_state()
        if not changed:
            return SetParametersResult(successful=True)
        if reason := self.describe_transition():
            return refused(reason)
        if state is State.FINALIZED:
            name = next(iter(changed))
            return refused(f"parameter {name} cannot be set any more: the node is finalized")
        try:
            settings = self._read_settings(changed)
            if state is State.UNCONFIGURED:
                self._make_transport(settings)
        except ConfigurationError as error:
            return refused(str(error))
        self._take_over(settings, state)
        return SetParametersResult(successful=True)

    def _take_over(self, settings: ReaderSettings, state: State) -> None:
        """Apply settings from now on, or once the reader is configured."""
        if state is State.INACTIVE:
            self._pipeline = self._make_pipeline(settings, self._settings.without_effect)
        elif state is State.ACTIVE and self._pipeline is not None:
            self._pipeline.redirect(self._make_outlet(settings))
        if state is not State.UNCONFIGURED:
            self._settings = settings

    def _make_pipeline(self, settings: ReaderSettings, said: Sequence[str] = ()) -> Pipeline:
        """Make the pipeline of a frame; `said` has been logged before."""
        for note in settings.without_effect:
            if note not in said:
                self.logger.warning(note)
        return Pipeline(settings, self._make_outlet(settings), self._counts, self.logger)

    def _make_outlet(self, settings: ReaderSettings) -> Outlet:
        assert self._topics is not None
        return Outlet(
            self._topics,
            lambda publisher, like, varying: self._connection.prepared_sender(
                publisher.inner, like, varying
            ),
            settings.frame_id,
            settings.covariances,
            self._counts,
            settings.mapping.groups,
        )

    def _stop_reading(self) -> None:
        if self._monitor_timer is not None:
            self._monitor_timer.destroy()
        self._last_health = self.last_health
        self._monitor = self._monitor_timer = None
        if self._transport is not None:
            self._transport.close()

    def _release(self) -> None:
        self._stop_reading()
        for publisher in self._publishers:
            self.destroy_publisher(publisher)
        self._publishers.clear()

    def _make_transport(self, settings: ReaderSettings) -> Transport:
        context = TransportContext(
            self.get_clock(),
            self.logger,
            settings.stale_timeout_s,
            frames_are_dated=settings.uses_device_time,
        )
        return make_transport(settings.transport, settings.transport_values, context)

    def _make_monitor(self, transport: Transport, pipeline: Pipeline) -> HealthMonitor:
        return HealthMonitor(
            transport,
            self._counts,
            lambda: self._finding(pipeline),
            self._settings.stale_timeout_s,
            self.get_clock(),
            self.logger,
            lambda reason: self._explain(reason, pipeline),
        )

    def _replace_transport(self, transport: Transport) -> None:
        """Use the new transport; keep the counts of the previous one."""
        for reason, number in self.transport_health.frame_errors.items():
            self._counts.add(reason, number)
        self._transport = transport

    def _publisher(self, msg_type: type[MessageT], topic: str) -> LifecyclePublisher[MessageT]:
        publisher = self.create_publisher(msg_type, topic, _DEPTH)
        self._publishers.append(publisher)
        return publisher

    def _read_settings(self, changed: Mapping[str, ParameterValue] = _NOTHING) -> ReaderSettings:
        """Return the settings from the parameters, with some of them changed."""
        settings = read_settings(
            self._registry, lambda name: changed[name] if name in changed else self._value(name)
        )
        check_names(settings.topic_namespace, settings.frame_id, self._connection.node_name)
        return settings

    def _value(self, name: str) -> Any:
        return self.get_parameter(name).value

    def _finding(self, pipeline: Pipeline) -> str:
        """Return the fault of published samples, in one line; empty if none."""
        fault = self._date_fault()
        return f"stamps are zero: {fault}" if fault else pipeline.finding

    def _explain(self, reason: str, pipeline: Pipeline) -> str:
        """Return the explanation of a reason for which samples are not published."""
        return (reason == "not_sent" and self._date_fault()) or pipeline.explain(reason)

    def _date_fault(self) -> str:
        """Return why the date is no stamp, if a sample has had it; empty otherwise."""
        return date_fault(self.get_clock().now_ns()) if self._counts.clock_unusable else ""


def _open(transport: Transport) -> None:
    """Open the device; release it if a signal interrupts that."""
    try:
        transport.open()
    except KeyboardInterrupt:
        transport.close()
        raise
