"""The parameters of one node, whose values from outside come from the recording."""

from collections.abc import Callable, Sequence
from typing import Any

from rosbase.contracts.parameter_store import ParameterRules, refused
from rosbase.contracts.recorded_answers import found, value_from, value_to
from rosbase.entries.conductor import Conductor
from rosbase.errors import ParameterError
from rosbase.local.standard.parameter_answers import value_message
from rosbase.messages import Time
from rosbase.messages import rcl_interfaces as msgs
from rosbase.parameters import (
    Parameter,
    ParameterKind,
    ParameterSpec,
    SetParametersResult,
    check_value,
)

__all__ = ["ReplayedParameters"]

_BYTE_ARRAY = 5


class ReplayedParameters(ParameterRules):
    """Declared parameters with their values, and the events that rclpy publishes of them."""

    def __init__(
        self,
        conductor: Conductor,
        node: str,
        report: Callable[[str], object],
        call_soon: Callable[[Callable[[], object]], object],
        publish: Callable[[msgs.ParameterEvent], object],
    ) -> None:
        """Start without a parameter.

        Args:
            conductor: The replay.
            node: Full name of the node.
            report: As for `ParameterRules`.
            call_soon: Queues a call for the main loop.
            publish: Publishes an event.
        """
        super().__init__(report)
        self._conductor, self._node = conductor, node
        self._call_soon, self._publish = call_soon, publish
        self._values: dict[str, Parameter[Any]] = {}
        self.describe_transition: Callable[[], str] = str
        """Says which transition runs; empty for none."""

    def declare(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare a parameter, with the value that it had."""
        if spec.name in self._values:
            raise ParameterError(f"parameter {spec.name} is declared twice")
        value = found(
            self._conductor, lambda: check_value(spec, spec.default), value_to, value_from
        )
        declared = self._values[spec.name] = Parameter(spec.name, check_value(spec, value))
        self.add(spec)
        if value == [] and spec.kind is not ParameterKind.BYTE_ARRAY:
            # rclpy takes an empty list for one of bytes, until it is told otherwise.
            self._tell_of("new_parameters", [_untyped(spec.name)])
            self._tell_of("changed_parameters", self._messages([declared]))
        else:
            self._tell_of("new_parameters", self._messages([declared]))
        return declared

    def get(self, name: str) -> Parameter[Any]:
        """Return the parameter with its current value; one of rclpy's with its recorded value."""
        known = self._values.get(name)
        if known is None:
            value = found(self._conductor, lambda: _refuse(name), value_to, value_from)
            return Parameter(name, value)
        # Whoever changes the list would get around the checks.
        return Parameter(name, list(known.value)) if isinstance(known.value, list) else known

    def names(self) -> list[str]:
        """Return the names of all parameters, with rclpy's own."""
        return list(found(self._conductor, lambda: list(self._values)))

    def set(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused."""
        try:
            checked = self.check(parameters)
        except ParameterError as error:
            return refused(str(error))
        if checked and self.has_callbacks:
            if reason := self._busy(checked):
                return refused(reason)
            answer = self.ask(checked)
            if not answer.successful:
                return refused(answer.reason)
        self._store(checked)
        self._tell_of("changed_parameters", self._messages(checked))
        if checked:
            self._call_soon(lambda: self.tell(checked))
        return SetParametersResult(successful=True)

    def take(self, checked: list[Parameter[Any]]) -> None:
        """Set parameters as others did, whose event was another thread's."""
        if not self.has_callbacks or self.ask(checked).successful:
            self._store(checked)
            self._call_soon(lambda: self.tell(checked))

    def _store(self, checked: Sequence[Parameter[Any]]) -> None:
        self._values |= {parameter.name: parameter for parameter in checked}

    def _busy(self, parameters: Sequence[Parameter[Any]]) -> str:
        specs = [self.find(parameter.name) for parameter in parameters]
        is_limited = any(spec is not None and spec.change_time != "always" for spec in specs)
        return self.describe_transition() if is_limited else ""

    def _tell_of(self, field: str, messages: Sequence[msgs.Parameter]) -> None:
        stamp = Time.as_stamp(self._conductor.clock.now_ns())
        lists: dict[str, Any] = {field: tuple(messages)}
        self._publish(msgs.ParameterEvent(stamp=stamp, node=self._node, **lists))

    def _messages(self, parameters: Sequence[Parameter[Any]]) -> list[msgs.Parameter]:
        return [
            msgs.Parameter(one.name, value_message(spec.kind, one.value))
            for one in parameters
            if (spec := self.find(one.name)) is not None
        ]


def _untyped(name: str) -> msgs.Parameter:
    return msgs.Parameter(name, msgs.ParameterValue(type=_BYTE_ARRAY))


def _refuse(name: str) -> Any:
    raise ParameterError(f"parameter {name} has not been declared")
