"""The parameters that a running program has when its recording begins. Later come their changes."""

from collections.abc import Mapping
from typing import Any

from rosbase import Clock, ControlError, QoSProfile
from rosbase.contracts.message_format import message_format
from rosbase.control.fleet import Fleet
from rosbase.messages import Time
from rosbase.messages.rcl_interfaces import Parameter, ParameterEvent, ParameterValue
from rosbase.parameters.described import KIND_NUMBERS
from rosbase_mcap.channel_table import QOS
from rosbase_mcap.qos_text import profiles_text
from rosbase_mcap.recorder import Recorder

__all__ = ["PARAMETER_EVENTS", "record_parameters"]

PARAMETER_EVENTS = "/parameter_events"
# As in rclpy.
_PROFILE = QoSProfile(1000)
_NUMBERS = {kind.name.lower(): number for kind, number in KIND_NUMBERS.items()}


def record_parameters(fleet: Fleet, recorder: Recorder, clock: Clock) -> int:
    """Record the values of all nodes, as if they were new; return the number of messages."""
    form = message_format(ParameterEvent)
    # The channel is the one of the topic, which is heard already.
    metadata = {QOS: profiles_text([_PROFILE])}
    record = recorder.channel(PARAMETER_EVENTS, form.type_name, form.schema, metadata)
    recorded = 0
    for node, names in fleet.parameter_names().items():
        try:
            values = fleet.typed_parameters(node, names) if names else {}
        except ControlError:
            # The node has ended, or declares and destroys at this moment.
            continue
        if values:
            stamp_ns = clock.now_ns()
            message = ParameterEvent(Time.as_stamp(stamp_ns), node, _parameters(values))
            record(stamp_ns, stamp_ns, form.encode(message))
            recorded += 1
    return recorded


def _parameters(values: Mapping[str, Mapping[str, Any]]) -> tuple[Parameter, ...]:
    return tuple(Parameter(name, _value(one["type"], one["value"])) for name, one in values.items())


def _value(kind: str, value: Any) -> ParameterValue:
    value = tuple(value) if isinstance(value, list) else value
    return ParameterValue(type=_NUMBERS[kind], **{f"{kind}_value": value})
