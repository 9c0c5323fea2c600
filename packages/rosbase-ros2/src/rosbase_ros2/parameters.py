"""Parameters of rosbase as parameters of a ROS node: declared, listed, checked when set."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from attrs import field, frozen
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rcl_interfaces.msg import SetParametersResult as RosResult
from rclpy.parameter import Parameter as RosParameter

from rosbase import (
    GivenParameterError,
    Parameter,
    ParameterError,
    ParameterKind,
    ParameterRules,
    ParameterSpec,
    ParameterValue,
    SetParametersResult,
    Written,
    check_value,
    from_outside,
    one_line,
    parse_written,
    refused,
)
from rosbase.parameters.described import KIND_NUMBERS, constraints, value_range
from rosbase_ros2.questions import Questions
from rosbase_ros2.refusals import RCLError, Refusals
from rosbase_ros2.written import is_guess_of

__all__ = ["Overrides", "RosParameters"]

_TYPES = {kind: RosParameter.Type(number) for kind, number in KIND_NUMBERS.items()}


@frozen
class Overrides:
    """Values that override the defaults of one node's parameters."""

    of_program: Mapping[str, ParameterValue] = field(factory=dict)
    """Values from the options of the backend; they override the command line."""
    guessed: Mapping[str, Any] = field(factory=dict)
    """Values that rcl has guessed from the command line and its files."""
    written: Mapping[str, Sequence[Written | None]] = field(factory=dict)
    """Values as written there, the last of which counts; None where the text is lost."""

    def value_of(self, spec: ParameterSpec) -> ParameterValue:
        """Return the value that a parameter is declared with.

        Raises:
            ParameterError: Its given value is invalid.
        """
        for name in filter(None, (spec.name, spec.general_name)):
            if name in self.of_program:
                return check_value(spec, self.of_program[name])
            if name in self.guessed:
                try:
                    return self._given(spec, name)
                except ParameterError as error:
                    raise GivenParameterError(str(error)) from error
        return check_value(spec, spec.default)

    def _given(self, spec: ParameterSpec, name: str) -> ParameterValue:
        guessed, texts = _plain(self.guessed[name]), self.written.get(name, ())
        # rcl keeps the first of two types that it guesses for one parameter, not the last.
        is_known = any(text is not None and is_guess_of(guessed, text) for text in texts)
        if is_known and (last := texts[-1]) is not None:
            return parse_written(spec, last)
        return from_outside(spec, guessed)


class RosParameters:
    """The parameters of one rclpy node.

    They are set from the main loop, or through services on rclpy's thread. Either way the program's
    callbacks run on the main loop.
    """

    def __init__(
        self,
        node: Any,
        overrides: Overrides,
        questions: Questions,
        refusals: Refusals,
        report: Callable[[str], object],
        call_soon: Callable[[Callable[[], object]], object],
    ) -> None:
        """Take over checking parameters when they are set.

        Args:
            node: The rclpy node.
            overrides: Values that override the defaults.
            questions: Asks the main loop.
            refusals: Judges messages that DDS refuses.
            report: Called with a line for each callback of the program that fails.
            call_soon: Queues a call for the main loop.
        """
        self._node = node
        self._overrides = overrides
        self._rules = ParameterRules(report)
        self.general_names: set[str] = set()
        """Names under which declared parameters take a value that is given to every node."""
        self._questions = questions
        self._refusals = refusals
        self.add_callback = self._rules.add_callback
        """Ask a callback on the main loop before parameters are set."""
        self.add_post_callback = self._rules.add_post_callback
        """Call a callback on the main loop after parameters were set."""
        self._call_soon = call_soon
        self._describe_transition: Callable[[], str] = str
        node.add_pre_set_parameters_callback(self._convert)
        node.add_on_set_parameters_callback(self._check)
        node.add_post_set_parameters_callback(self._tell)

    def watch_transitions(self, describe_transition: Callable[[], str]) -> None:
        """Refuse at once, while a transition runs, what may not change in every state.

        The main loop, which may run the transition, could only be asked later.
        """
        self._describe_transition = describe_transition

    def _busy(self, parameters: Sequence[Parameter[Any]]) -> str:
        specs = [self._rules.find(parameter.name) for parameter in parameters]
        is_limited = any(spec is not None and spec.change_time != "always" for spec in specs)
        return self._describe_transition() if is_limited else ""

    def declare(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare the parameter on the node, with its value from outside if there is one.

        Raises:
            ParameterError: It is declared already, or its given value is invalid.
        """
        if self._node.has_parameter(spec.name):
            raise ParameterError(f"parameter {spec.name} is declared twice")
        value = self._value_of(spec)
        try:
            # Not by rclpy, which knows the overrides by the types that rcl guesses.
            declare = partial(self._node.declare_parameter, ignore_override=True)
            self._change(declare, spec.name, value, _descriptor(spec))
        except Exception as error:
            raise ParameterError(one_line(str(error))) from error
        if self._node.get_parameter(spec.name).type_ is not _TYPES[spec.kind]:
            # An empty list, which rclpy takes for one of bytes.
            parameter = RosParameter(spec.name, _TYPES[spec.kind], value)
            self._change(self._node.set_parameters, [parameter])
        self._rules.add(spec)
        self.general_names.add(spec.general_name)
        return Parameter(spec.name, value)

    def _value_of(self, spec: ParameterSpec) -> ParameterValue:
        return self._overrides.value_of(spec)

    def get(self, name: str) -> Parameter[Any]:
        """Return the parameter with its current value.

        Raises:
            ParameterError: It has not been declared.
        """
        if not self._node.has_parameter(name):
            raise ParameterError(f"parameter {name} has not been declared")
        value = self._node.get_parameter(name).value
        spec = self._rules.find(name)
        return Parameter(name, value if spec is None else check_value(spec, _plain(value)))

    def names(self) -> list[str]:
        """Return the names of all parameters of the node, in the order of declaration."""
        # Not by rclpy's `list_parameters`, which fails if another thread declares one meanwhile.
        return list(self._node._parameters)

    def describe(self, name: str) -> ParameterSpec:
        """Return the declaration of a parameter, or what ROS tells of one that is not rosbase's.

        Raises:
            ParameterError: It has not been declared.
        """
        spec = self._rules.find(name)
        if spec is not None:
            return spec
        if not self._node.has_parameter(name):
            raise ParameterError(f"parameter {name} has not been declared")
        found, descriptor = self._node.get_parameter(name), self._node.describe_parameter(name)
        kinds = {ros_type: kind for kind, ros_type in _TYPES.items()}
        # One without a value is shown as an empty text.
        kind = kinds.get(found.type_, ParameterKind.STRING)
        value = "" if found.value is None else _plain(found.value)
        return ParameterSpec(
            name, value, descriptor.description, kind=kind, read_only=descriptor.read_only
        )

    def set(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused. Call it on the main loop."""
        # Some are of rclpy, such as use_sim_time.
        theirs = [p for p in parameters if self._rules.find(p.name) is None]
        theirs = [p for p in theirs if self._node.has_parameter(p.name)]
        try:
            checked = self._rules.check([p for p in parameters if p not in theirs])
        except ParameterError as error:
            return refused(str(error))
        given = [
            RosParameter(parameter.name, _TYPES[self._kind(parameter.name)], parameter.value)
            for parameter in [*checked, *theirs]
        ]
        try:
            answer = self._node.set_parameters_atomically(given)
        except RCLError as error:
            # They are set all the same; at some dates DDS does not take the event.
            self._refusals.judge("/parameter_events", error)
            return SetParametersResult(successful=True)
        return SetParametersResult(answer.successful, answer.reason)

    def _tell(self, parameters: list[Any]) -> None:
        ours = [
            Parameter(parameter.name, check_value(spec, _plain(parameter.value)))
            for parameter in parameters
            if (spec := self._rules.find(parameter.name)) is not None
        ]
        if ours:
            self._call_soon(lambda: self._rules.tell(ours))

    def _kind(self, name: str) -> ParameterKind:
        return self.describe(name).kind

    def _convert(self, parameters: list[Any]) -> list[Any]:
        """Convert each value to the declared type: tools guess the type of `2` and `[]`."""
        return [self._as_declared(parameter) for parameter in parameters]

    def _as_declared(self, parameter: Any) -> Any:
        spec = self._rules.find(parameter.name)
        if spec is None:
            return parameter
        try:
            value = from_outside(spec, _plain(parameter.value))
        except ParameterError:
            # Refused with the reason when it is checked.
            return parameter
        return RosParameter(spec.name, _TYPES[spec.kind], value)

    def _change(self, call: Callable[..., Any], *arguments: Any) -> None:
        """Change parameters with rclpy, which also publishes the change as an event."""
        try:
            call(*arguments)
        except RCLError as error:
            # It changes them first; at some dates DDS does not take the event.
            self._refusals.judge("/parameter_events", error)

    def _check(self, parameters: list[Any]) -> Any:
        try:
            checked = self._checked(parameters)
        except ParameterError as error:
            return RosResult(successful=False, reason=str(error))
        if checked and self._rules.has_callbacks:
            if reason := self._busy(checked):
                return RosResult(successful=False, reason=reason)
            answer = self._questions.ask(lambda: self._rules.ask(checked), refused)
            return RosResult(successful=bool(answer.successful), reason=answer.reason)
        return RosResult(successful=True)

    def _checked(self, parameters: list[Any]) -> list[Parameter[Any]]:
        ours = [p for p in parameters if self._rules.find(p.name) is not None]
        return self._rules.check([Parameter(p.name, _plain(p.value)) for p in ours])


def _plain(value: Any) -> Any:
    """Convert arrays of numbers, which come as `array.array`."""
    return value.tolist() if hasattr(value, "tolist") else value


def _descriptor(spec: ParameterSpec) -> Any:
    descriptor = ParameterDescriptor(
        description=spec.description,
        additional_constraints=constraints(spec),
        # A whole number is taken where a double is due; `check_value` decides about the rest.
        dynamic_typing=True,
        read_only=spec.read_only,
    )
    if limits := value_range(spec):
        least, most = limits
        if spec.kind is ParameterKind.INTEGER:
            descriptor.integer_range = [IntegerRange(from_value=least, to_value=most)]
        else:
            descriptor.floating_point_range = [FloatingPointRange(from_value=least, to_value=most)]
    return descriptor
