"""Parameters of rosbase as parameters of a ROS node: declared, listed, checked when set."""

from typing import Any

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.parameter import Parameter as RosParameter

from rosbase import (
    Parameter,
    ParameterError,
    ParameterKind,
    ParameterSpec,
    check_value,
    one_line,
)

__all__ = ["RosParameters"]

_TYPES = {
    ParameterKind.BOOL: RosParameter.Type.BOOL,
    ParameterKind.INTEGER: RosParameter.Type.INTEGER,
    ParameterKind.DOUBLE: RosParameter.Type.DOUBLE,
    ParameterKind.STRING: RosParameter.Type.STRING,
    ParameterKind.DOUBLE_ARRAY: RosParameter.Type.DOUBLE_ARRAY,
    ParameterKind.STRING_ARRAY: RosParameter.Type.STRING_ARRAY,
}
_HUGE = 1.7976931348623157e308
_INT64 = 2**63


class RosParameters:
    """The parameters of one rclpy node."""

    def __init__(self, node: Any) -> None:
        """Takes over the checking of what is set from outside."""
        self._node = node
        self._specs: dict[str, ParameterSpec] = {}
        node.add_on_set_parameters_callback(self._check)

    def declare(self, spec: ParameterSpec) -> Parameter:
        """Declares it on the node, with the value that it was given from outside, if it was.

        Raises:
            ParameterError: It is declared already, or what it was given is not a value of it.
        """
        if self._node.has_parameter(spec.name):
            raise ParameterError(f"parameter {spec.name} is declared twice")
        try:
            given = self._node.declare_parameter(spec.name, spec.default, _descriptor(spec))
        except Exception as error:
            raise ParameterError(one_line(str(error))) from error
        try:
            value = check_value(spec, _plain(given.value))
        except ParameterError:
            self._node.undeclare_parameter(spec.name)
            raise
        if given.type_ is not _TYPES[spec.kind]:
            # A whole number for a double, or an empty list, which rclpy takes for one of bytes.
            self._node.set_parameters([RosParameter(spec.name, _TYPES[spec.kind], value)])
        self._specs[spec.name] = spec
        return Parameter(spec.name, value)

    def get(self, name: str) -> Parameter:
        """The parameter as it is now.

        Raises:
            ParameterError: It has not been declared.
        """
        if not self._node.has_parameter(name):
            raise ParameterError(f"parameter {name} has not been declared")
        value = self._node.get_parameter(name).value
        spec = self._specs.get(name)
        return Parameter(name, value if spec is None else check_value(spec, _plain(value)))

    def _check(self, parameters: list[Any]) -> Any:
        for parameter in parameters:
            spec = self._specs.get(parameter.name)
            if spec is None:
                continue
            try:
                check_value(spec, _plain(parameter.value))
            except ParameterError as error:
                return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)


def _plain(value: Any) -> Any:
    """Arrays of numbers come as `array.array`."""
    return value.tolist() if hasattr(value, "tolist") else value


def _descriptor(spec: ParameterSpec) -> Any:
    descriptor = ParameterDescriptor(
        description=spec.description,
        additional_constraints=", ".join(spec.choices) and f"one of {', '.join(spec.choices)}",
        # A whole number is taken where a double is due; `check_value` decides about the rest.
        dynamic_typing=True,
    )
    if spec.minimum is not None or spec.maximum is not None:
        least, most = spec.minimum, spec.maximum
        if spec.kind is ParameterKind.INTEGER:
            descriptor.integer_range = [
                IntegerRange(
                    from_value=-_INT64 if least is None else int(least),
                    to_value=_INT64 - 1 if most is None else int(most),
                )
            ]
        elif spec.kind is ParameterKind.DOUBLE:
            descriptor.floating_point_range = [
                FloatingPointRange(
                    from_value=-_HUGE if least is None else float(least),
                    to_value=_HUGE if most is None else float(most),
                )
            ]
    return descriptor
