"""Messages about changed parameters, as the nodes of rclpy publish them.

Imported when somebody has subscribed and a parameter changes.
"""

from collections.abc import Iterable, Mapping

from rosbase.contracts.parameter_store import ParameterStore
from rosbase.local.standard.node_parameters import NodeParameters
from rosbase.local.standard.parameter_answers import value_message
from rosbase.messages import Time
from rosbase.messages import rcl_interfaces as msgs

__all__ = ["parameter_events"]


def parameter_events(
    store: ParameterStore,
    prefixes: Mapping[str, str],
    changed: Iterable[str],
    stamp: Time,
    *,
    are_new: bool,
) -> list[msgs.ParameterEvent]:
    """Return a message for each node that has some of the parameters.

    Args:
        store: The parameters of all nodes.
        prefixes: By node, the beginning of its parameters in the store.
        changed: Names of the parameters in the store.
        stamp: The date.
        are_new: Whether they have just been declared.
    """
    field = "new_parameters" if are_new else "changed_parameters"
    events = []
    for node, prefix in prefixes.items():
        parameters = NodeParameters(store, prefix, prefixes.values())
        own = [parameters.inner_name(full) for full in changed if parameters.has(full)]
        messages = tuple(_message(parameters, name) for name in own)
        if messages:
            events.append(msgs.ParameterEvent(stamp=stamp, node=node, **{field: messages}))
    return events


def _message(parameters: NodeParameters, name: str) -> msgs.Parameter:
    spec = parameters.find(name)
    assert spec is not None
    return msgs.Parameter(name, value_message(spec.kind, parameters.value(name)))
