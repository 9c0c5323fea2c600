"""How a node answers the standard services of its parameters, as rclpy does.

Imported when the first request comes.
"""

from collections.abc import Iterable, Sequence
from functools import partial
from typing import Any

from rosbase.contracts.parameter_store import refused
from rosbase.errors import ParameterError
from rosbase.local.standard.listing import list_names
from rosbase.local.standard.node_parameters import NodeParameters
from rosbase.local.standard.node_services import Answers
from rosbase.messages import rcl_interfaces as msgs
from rosbase.parameters import (
    Parameter,
    ParameterKind,
    ParameterSpec,
    SetParametersResult,
    from_outside,
)
from rosbase.parameters.described import KIND_NUMBERS, constraints, value_range

__all__ = ["parameter_answers", "value_message"]

_FIELDS = {number: f"{kind.name.lower()}_value" for kind, number in KIND_NUMBERS.items()}
"""Field of ParameterValue that has the value, by the number of the type."""


def parameter_answers(parameters: NodeParameters) -> Answers:
    """Return the answers for the parameters of a node."""
    return {
        "describe_parameters": (msgs.DescribeParameters, partial(_describe, parameters)),
        "get_parameters": (msgs.GetParameters, partial(_get, parameters)),
        "get_parameter_types": (msgs.GetParameterTypes, partial(_get_types, parameters)),
        "list_parameters": (msgs.ListParameters, partial(_list, parameters)),
        "set_parameters": (msgs.SetParameters, partial(_set, parameters)),
        "set_parameters_atomically": (
            msgs.SetParametersAtomically,
            partial(_set_atomically, parameters),
        ),
    }


def _describe(
    parameters: NodeParameters, request: msgs.DescribeParameters_Request
) -> msgs.DescribeParameters_Response:
    specs = _specs(parameters, request.names)
    found = zip(request.names, specs, strict=False)
    return msgs.DescribeParameters_Response(tuple(_descriptor(*one) for one in found))


def _get(
    parameters: NodeParameters, request: msgs.GetParameters_Request
) -> msgs.GetParameters_Response:
    specs = _specs(parameters, request.names)
    found = zip(request.names, specs, strict=False)
    return msgs.GetParameters_Response(
        tuple(value_message(spec.kind, parameters.value(name)) for name, spec in found)
    )


def _get_types(
    parameters: NodeParameters, request: msgs.GetParameterTypes_Request
) -> msgs.GetParameterTypes_Response:
    specs = _specs(parameters, request.names)
    return msgs.GetParameterTypes_Response(tuple(KIND_NUMBERS[spec.kind] for spec in specs))


def _list(
    parameters: NodeParameters, request: msgs.ListParameters_Request
) -> msgs.ListParameters_Response:
    names, prefixes = list_names(parameters.names(), request.prefixes, request.depth)
    return msgs.ListParameters_Response(msgs.ListParametersResult(tuple(names), tuple(prefixes)))


def _set(
    parameters: NodeParameters, request: msgs.SetParameters_Request
) -> msgs.SetParameters_Response:
    results = (_set_together(parameters, [one]) for one in request.parameters)
    return msgs.SetParameters_Response(tuple(map(_as_result, results)))


def _set_atomically(
    parameters: NodeParameters, request: msgs.SetParametersAtomically_Request
) -> msgs.SetParametersAtomically_Response:
    result = _set_together(parameters, request.parameters)
    return msgs.SetParametersAtomically_Response(_as_result(result))


def _specs(parameters: NodeParameters, names: Iterable[str]) -> list[ParameterSpec]:
    """Return the declarations; none if one of the names is unknown, as in ROS."""
    found = [parameters.find(name) for name in names]
    known = [spec for spec in found if spec is not None]
    return known if len(known) == len(found) else []


def _set_together(
    parameters: NodeParameters, messages: Sequence[msgs.Parameter]
) -> SetParametersResult:
    try:
        given = [Parameter(m.name, _value(parameters, m)) for m in messages]
    except ParameterError as error:
        return refused(str(error))
    return parameters.set(given)


def _value(parameters: NodeParameters, message: msgs.Parameter) -> Any:
    """Return the value of a message, in the declared type if a tool guessed another.

    Raises:
        ParameterError: Its type does not exist.
    """
    number = message.value.type
    if number == msgs.ParameterType.PARAMETER_NOT_SET:
        # A declared parameter always has a value, so this one will be refused.
        return None
    # The fields of a request within one process may hold anything.
    if not isinstance(number, int) or number not in _FIELDS:
        raise ParameterError(f"parameter {message.name}: there is no type {number!r}")
    value = getattr(message.value, _FIELDS[number])
    spec = parameters.find(message.name)
    try:
        return value if spec is None else from_outside(spec, value)
    except ParameterError:
        # Refused with the reason when it is checked.
        return value


def value_message(kind: ParameterKind, value: Any) -> msgs.ParameterValue:
    """Return the message of a value of that kind."""
    if kind is ParameterKind.BYTE_ARRAY:
        value = tuple(item[0] for item in value)
    elif isinstance(value, list):
        value = tuple(value)
    number = KIND_NUMBERS[kind]
    values: dict[str, Any] = {_FIELDS[number]: value}
    return msgs.ParameterValue(type=number, **values)


def _descriptor(name: str, spec: ParameterSpec) -> msgs.ParameterDescriptor:
    limits: dict[str, Any] = {}
    if found := value_range(spec):
        least, most = found
        if spec.kind is ParameterKind.INTEGER:
            limits = {"integer_range": (msgs.IntegerRange(int(least), int(most)),)}
        else:
            limits = {"floating_point_range": (msgs.FloatingPointRange(least, most),)}
    return msgs.ParameterDescriptor(
        name=name,
        type=KIND_NUMBERS[spec.kind],
        description=spec.description,
        additional_constraints=constraints(spec),
        read_only=spec.read_only,
        # As on ROS: a whole number is taken where a double is due.
        dynamic_typing=True,
        **limits,
    )


def _as_result(result: SetParametersResult) -> msgs.SetParametersResult:
    return msgs.SetParametersResult(successful=result.successful, reason=result.reason)
