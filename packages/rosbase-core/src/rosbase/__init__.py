"""A framework for robot applications: four roles and a managed lifecycle, with or without ROS.

Programs and plugins import from here, and from `rosbase.messages`, `rosbase.wire`, `rosbase.fsm`,
`rosbase.lifecycle`, `rosbase.control`, `rosbase.utils` and `rosbase.testing`. The modules that
define the names may change.
"""

from __future__ import annotations

# Not from `typing`, whose import takes half as long as the start of Python: commands that ask a
# running program are over before.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.clock import (
        Clock,
        SystemClock,
        date_fault,
    )
    from rosbase.contracts.backend import (
        Backend,
        BackendOptions,
        timer_period_ns,
    )
    from rosbase.contracts.checks import (
        CheckContext,
        Finding,
        Outcome,
    )
    from rosbase.contracts.graph import Graph, ServiceEnd, TopicEnd, type_name_of
    from rosbase.contracts.message_format import MessageFormat
    from rosbase.contracts.names import (
        check_node_name,
        resolve_topic,
    )
    from rosbase.contracts.new_ends import NewEnds
    from rosbase.contracts.node_connection import (
        NodeConnection,
        Publisher,
        Sender,
        Subscription,
        Timer,
    )
    from rosbase.contracts.parameter_store import (
        OnSetParameters,
        ParameterRules,
        ParameterStore,
        PostSetParameters,
        name_undeclared,
        refused,
    )
    from rosbase.contracts.recording import Recording, RecordOptions
    from rosbase.contracts.service_call import ServiceCall
    from rosbase.contracts.service_callback import check_service_type, service_answer
    from rosbase.contracts.service_client import ServiceClient
    from rosbase.contracts.service_server import ServiceRequest, ServiceServer
    from rosbase.contracts.services import (
        Client,
        Service,
        ServiceCallback,
        ServiceFuture,
        ServiceType,
    )
    from rosbase.contracts.stamper import (
        Stamper,
    )
    from rosbase.contracts.tap import Tap
    from rosbase.contracts.transport import (
        OnFrame,
        PluggableDevice,
        SimulatedDevice,
        Tally,
        Transport,
        TransportContext,
        TransportHealth,
        TransportState,
        hand_over,
    )
    from rosbase.device import (
        Device,
        DeviceReport,
        DeviceTransport,
        OpenDevice,
        ReportingDevice,
    )
    from rosbase.errors import (
        BackendError,
        ConfigurationError,
        ControlError,
        DeviceBusyError,
        DeviceNotFoundError,
        DevicePermissionError,
        GivenParameterError,
        HandshakeTimeoutError,
        MappingError,
        NotADeviceError,
        NotInstalledError,
        ParameterError,
        PluginError,
        RecordingError,
        RosbaseError,
        ServiceDepthError,
        ServiceError,
        ServiceFailedError,
        ServiceStoppedError,
        ServiceTimeoutError,
        TransitionNotAvailableError,
        TransportError,
        WireError,
    )
    from rosbase.framing import (
        Frame,
        FrameError,
        FrameEvent,
        Framer,
        LineFramer,
    )
    from rosbase.imu.mapping import (
        ImuMapping,
    )
    from rosbase.imu.reader import (
        ImuReader,
    )
    from rosbase.imu.simulator import (
        ImuSimulator,
    )
    from rosbase.launcher import BaseLauncher
    from rosbase.lifecycle import (
        CallbackReturn,
        ManagedNode,
        State,
        TransitionEvent,
    )
    from rosbase.local import LocalBackend
    from rosbase.logger import (
        LogOptions,
        RosbaseLogger,
        RosFormatter,
        log_to_file,
        make_logger,
    )
    from rosbase.manager import (
        BaseManager,
    )
    from rosbase.mapping import (
        Batch,
        PayloadMapping,
        Quantity,
        Reject,
        TimeMapping,
    )
    from rosbase.messages.fields import message
    from rosbase.parameters import (
        Parameter,
        ParameterKind,
        ParameterSpec,
        ParameterValue,
        SetParametersResult,
        Written,
        WrittenText,
        check_value,
        did_you_mean,
        from_outside,
        parse_text,
        parse_written,
    )
    from rosbase.plugins import (
        BackendPlugin,
        CheckPlugin,
        CommandPlugin,
        ConversionPlugin,
        Descriptor,
        PluginRegistry,
        PresetPlugin,
        RecorderPlugin,
        TransportPlugin,
        hookimpl,
        installed_plugins,
    )
    from rosbase.processes import (
        RestartPolicy,
        register_multiprocess_nodes,
        shutdown_multiprocess_nodes,
    )
    from rosbase.program import take_arguments
    from rosbase.qos import (
        DurabilityPolicy,
        HistoryPolicy,
        QoSProfile,
        ReliabilityPolicy,
        as_profile,
        mismatch,
        qos_profile_sensor_data,
    )
    from rosbase.roles.agent import (
        BaseAgent,
    )
    from rosbase.roles.handlers import (
        BaseHandlers,
    )
    from rosbase.roles.latest import (
        Latest,
    )
    from rosbase.roles.lifecycle_node import (
        Autostart,
        LifecycleNode,
    )
    from rosbase.roles.lifecycle_publisher import (
        LifecyclePublisher,
    )
    from rosbase.roles.node import (
        BaseNode,
    )
    from rosbase.runtime.backoff import (
        Backoff,
    )
    from rosbase.runtime.executor import (
        Executor,
        ExecutorTimer,
    )
    from rosbase.runtime.queued_subscription import (
        QueuedSubscription,
    )
    from rosbase.runtime.signal_masks import (
        background_thread,
    )
    from rosbase.runtime.wake_pipe import (
        WakePipe,
    )
    from rosbase.text.printable import (
        one_line,
        printable,
    )

__version__: str
"""Version of rosbase-core that is installed."""

__all__ = [
    "Autostart",
    "Backend",
    "BackendError",
    "BackendOptions",
    "BackendPlugin",
    "Backoff",
    "BaseAgent",
    "BaseHandlers",
    "BaseLauncher",
    "BaseManager",
    "BaseNode",
    "Batch",
    "CallbackReturn",
    "CheckContext",
    "CheckPlugin",
    "Client",
    "Clock",
    "CommandPlugin",
    "ConfigurationError",
    "ControlError",
    "ConversionPlugin",
    "Descriptor",
    "Device",
    "DeviceBusyError",
    "DeviceNotFoundError",
    "DevicePermissionError",
    "DeviceReport",
    "DeviceTransport",
    "DurabilityPolicy",
    "Executor",
    "ExecutorTimer",
    "Finding",
    "Frame",
    "FrameError",
    "FrameEvent",
    "Framer",
    "GivenParameterError",
    "Graph",
    "HandshakeTimeoutError",
    "HistoryPolicy",
    "ImuMapping",
    "ImuReader",
    "ImuSimulator",
    "Latest",
    "LifecycleNode",
    "LifecyclePublisher",
    "LineFramer",
    "LocalBackend",
    "LogOptions",
    "ManagedNode",
    "MappingError",
    "MessageFormat",
    "NewEnds",
    "NodeConnection",
    "NotADeviceError",
    "NotInstalledError",
    "OnFrame",
    "OnSetParameters",
    "OpenDevice",
    "Outcome",
    "Parameter",
    "ParameterError",
    "ParameterKind",
    "ParameterRules",
    "ParameterSpec",
    "ParameterStore",
    "ParameterValue",
    "PayloadMapping",
    "PluggableDevice",
    "PluginError",
    "PluginRegistry",
    "PostSetParameters",
    "PresetPlugin",
    "Publisher",
    "QoSProfile",
    "Quantity",
    "QueuedSubscription",
    "RecordOptions",
    "RecorderPlugin",
    "Recording",
    "RecordingError",
    "Reject",
    "ReliabilityPolicy",
    "ReportingDevice",
    "RestartPolicy",
    "RosFormatter",
    "RosbaseError",
    "RosbaseLogger",
    "Sender",
    "Service",
    "ServiceCall",
    "ServiceCallback",
    "ServiceClient",
    "ServiceDepthError",
    "ServiceEnd",
    "ServiceError",
    "ServiceFailedError",
    "ServiceFuture",
    "ServiceRequest",
    "ServiceServer",
    "ServiceStoppedError",
    "ServiceTimeoutError",
    "ServiceType",
    "SetParametersResult",
    "SimulatedDevice",
    "Stamper",
    "State",
    "Subscription",
    "SystemClock",
    "Tally",
    "Tap",
    "TimeMapping",
    "Timer",
    "TopicEnd",
    "TransitionEvent",
    "TransitionNotAvailableError",
    "Transport",
    "TransportContext",
    "TransportError",
    "TransportHealth",
    "TransportPlugin",
    "TransportState",
    "WakePipe",
    "WireError",
    "Written",
    "WrittenText",
    "as_profile",
    "background_thread",
    "check_node_name",
    "check_service_type",
    "check_value",
    "date_fault",
    "did_you_mean",
    "from_outside",
    "hand_over",
    "hookimpl",
    "installed_plugins",
    "log_to_file",
    "make_logger",
    "message",
    "mismatch",
    "name_undeclared",
    "one_line",
    "parse_text",
    "parse_written",
    "printable",
    "qos_profile_sensor_data",
    "refused",
    "register_multiprocess_nodes",
    "resolve_topic",
    "service_answer",
    "shutdown_multiprocess_nodes",
    "take_arguments",
    "timer_period_ns",
    "type_name_of",
]

_HOMES = {
    "Autostart": "rosbase.roles.lifecycle_node",
    "Backend": "rosbase.contracts.backend",
    "BackendError": "rosbase.errors",
    "BackendOptions": "rosbase.contracts.backend",
    "BackendPlugin": "rosbase.plugins",
    "Backoff": "rosbase.runtime.backoff",
    "BaseAgent": "rosbase.roles.agent",
    "BaseHandlers": "rosbase.roles.handlers",
    "BaseLauncher": "rosbase.launcher",
    "BaseManager": "rosbase.manager",
    "BaseNode": "rosbase.roles.node",
    "Batch": "rosbase.mapping",
    "CallbackReturn": "rosbase.lifecycle",
    "CheckContext": "rosbase.contracts.checks",
    "CheckPlugin": "rosbase.plugins",
    "Client": "rosbase.contracts.services",
    "Clock": "rosbase.clock",
    "CommandPlugin": "rosbase.plugins",
    "ConfigurationError": "rosbase.errors",
    "ControlError": "rosbase.errors",
    "ConversionPlugin": "rosbase.plugins",
    "Descriptor": "rosbase.plugins",
    "Device": "rosbase.device",
    "DeviceBusyError": "rosbase.errors",
    "DeviceNotFoundError": "rosbase.errors",
    "DevicePermissionError": "rosbase.errors",
    "DeviceReport": "rosbase.device",
    "DeviceTransport": "rosbase.device",
    "DurabilityPolicy": "rosbase.qos",
    "Executor": "rosbase.runtime.executor",
    "ExecutorTimer": "rosbase.runtime.executor",
    "Finding": "rosbase.contracts.checks",
    "Frame": "rosbase.framing",
    "FrameError": "rosbase.framing",
    "FrameEvent": "rosbase.framing",
    "Framer": "rosbase.framing",
    "GivenParameterError": "rosbase.errors",
    "Graph": "rosbase.contracts.graph",
    "HandshakeTimeoutError": "rosbase.errors",
    "HistoryPolicy": "rosbase.qos",
    "ImuMapping": "rosbase.imu.mapping",
    "ImuReader": "rosbase.imu.reader",
    "ImuSimulator": "rosbase.imu.simulator",
    "Latest": "rosbase.roles.latest",
    "LifecycleNode": "rosbase.roles.lifecycle_node",
    "LifecyclePublisher": "rosbase.roles.lifecycle_publisher",
    "LineFramer": "rosbase.framing",
    "LocalBackend": "rosbase.local",
    "LogOptions": "rosbase.logger",
    "ManagedNode": "rosbase.lifecycle",
    "MappingError": "rosbase.errors",
    "MessageFormat": "rosbase.contracts.message_format",
    "NewEnds": "rosbase.contracts.new_ends",
    "NodeConnection": "rosbase.contracts.node_connection",
    "NotADeviceError": "rosbase.errors",
    "NotInstalledError": "rosbase.errors",
    "OnFrame": "rosbase.contracts.transport",
    "OnSetParameters": "rosbase.contracts.parameter_store",
    "OpenDevice": "rosbase.device",
    "Outcome": "rosbase.contracts.checks",
    "Parameter": "rosbase.parameters",
    "ParameterError": "rosbase.errors",
    "ParameterKind": "rosbase.parameters",
    "ParameterRules": "rosbase.contracts.parameter_store",
    "ParameterSpec": "rosbase.parameters",
    "ParameterStore": "rosbase.contracts.parameter_store",
    "ParameterValue": "rosbase.parameters",
    "PayloadMapping": "rosbase.mapping",
    "PluggableDevice": "rosbase.contracts.transport",
    "PluginError": "rosbase.errors",
    "PluginRegistry": "rosbase.plugins",
    "PostSetParameters": "rosbase.contracts.parameter_store",
    "PresetPlugin": "rosbase.plugins",
    "Publisher": "rosbase.contracts.node_connection",
    "QoSProfile": "rosbase.qos",
    "Quantity": "rosbase.mapping",
    "QueuedSubscription": "rosbase.runtime.queued_subscription",
    "RecordOptions": "rosbase.contracts.recording",
    "RecorderPlugin": "rosbase.plugins",
    "Recording": "rosbase.contracts.recording",
    "RecordingError": "rosbase.errors",
    "Reject": "rosbase.mapping",
    "ReliabilityPolicy": "rosbase.qos",
    "ReportingDevice": "rosbase.device",
    "RestartPolicy": "rosbase.processes",
    "RosFormatter": "rosbase.logger",
    "RosbaseError": "rosbase.errors",
    "RosbaseLogger": "rosbase.logger",
    "Sender": "rosbase.contracts.node_connection",
    "Service": "rosbase.contracts.services",
    "ServiceCall": "rosbase.contracts.service_call",
    "ServiceCallback": "rosbase.contracts.services",
    "ServiceClient": "rosbase.contracts.service_client",
    "ServiceDepthError": "rosbase.errors",
    "ServiceEnd": "rosbase.contracts.graph",
    "ServiceError": "rosbase.errors",
    "ServiceFailedError": "rosbase.errors",
    "ServiceFuture": "rosbase.contracts.services",
    "ServiceRequest": "rosbase.contracts.service_server",
    "ServiceServer": "rosbase.contracts.service_server",
    "ServiceStoppedError": "rosbase.errors",
    "ServiceTimeoutError": "rosbase.errors",
    "ServiceType": "rosbase.contracts.services",
    "SetParametersResult": "rosbase.parameters",
    "SimulatedDevice": "rosbase.contracts.transport",
    "Stamper": "rosbase.contracts.stamper",
    "State": "rosbase.lifecycle",
    "Subscription": "rosbase.contracts.node_connection",
    "SystemClock": "rosbase.clock",
    "Tally": "rosbase.contracts.transport",
    "Tap": "rosbase.contracts.tap",
    "TimeMapping": "rosbase.mapping",
    "Timer": "rosbase.contracts.node_connection",
    "TopicEnd": "rosbase.contracts.graph",
    "TransitionEvent": "rosbase.lifecycle",
    "TransitionNotAvailableError": "rosbase.errors",
    "Transport": "rosbase.contracts.transport",
    "TransportContext": "rosbase.contracts.transport",
    "TransportError": "rosbase.errors",
    "TransportHealth": "rosbase.contracts.transport",
    "TransportPlugin": "rosbase.plugins",
    "TransportState": "rosbase.contracts.transport",
    "WakePipe": "rosbase.runtime.wake_pipe",
    "WireError": "rosbase.errors",
    "Written": "rosbase.parameters",
    "WrittenText": "rosbase.parameters",
    "as_profile": "rosbase.qos",
    "background_thread": "rosbase.runtime.signal_masks",
    "check_node_name": "rosbase.contracts.names",
    "check_service_type": "rosbase.contracts.service_callback",
    "check_value": "rosbase.parameters",
    "date_fault": "rosbase.clock",
    "did_you_mean": "rosbase.parameters",
    "from_outside": "rosbase.parameters",
    "hand_over": "rosbase.contracts.transport",
    "hookimpl": "rosbase.plugins",
    "installed_plugins": "rosbase.plugins",
    "log_to_file": "rosbase.logger",
    "make_logger": "rosbase.logger",
    "message": "rosbase.messages.fields",
    "mismatch": "rosbase.qos",
    "name_undeclared": "rosbase.contracts.parameter_store",
    "one_line": "rosbase.text.printable",
    "parse_text": "rosbase.parameters",
    "parse_written": "rosbase.parameters",
    "printable": "rosbase.text.printable",
    "qos_profile_sensor_data": "rosbase.qos",
    "refused": "rosbase.contracts.parameter_store",
    "register_multiprocess_nodes": "rosbase.processes",
    "resolve_topic": "rosbase.contracts.names",
    "service_answer": "rosbase.contracts.service_callback",
    "shutdown_multiprocess_nodes": "rosbase.processes",
    "take_arguments": "rosbase.program",
    "timer_period_ns": "rosbase.contracts.backend",
    "type_name_of": "rosbase.contracts.graph",
}
# Programs import from these, too. Python puts each among the names here once it is imported.
_PUBLIC_MODULES = {"control", "fsm", "lifecycle", "messages", "testing", "utils", "wire"}


def __getattr__(name: str) -> Any:
    """Import each name on first use, so that the command line starts at once."""
    from importlib import import_module

    if name == "__version__":
        value: Any = import_module("importlib.metadata").version("rosbase-core")
    elif name in _HOMES:
        value = getattr(import_module(_HOMES[name]), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names, and those that Python gives every module."""
    ours = {"__version__", *__all__, *_PUBLIC_MODULES & globals().keys()}
    return sorted({*ours, *(name for name in globals() if name.startswith("__"))})
