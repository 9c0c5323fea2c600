"""The parameters of a node whose program is recorded.

Parameters that others set are entries. rclpy stores their values on its own thread. So the program
reads a copy, which changes on the main loop.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.msg import SetParametersResult as RosResult
from rclpy.serialization import serialize_message

from rosbase import Parameter, ParameterError, ParameterSpec, SetParametersResult, refused
from rosbase.contracts.recorded_answers import found, parameters_to, value_from, value_to
from rosbase.entries.conductor import Conductor
from rosbase.entries.kinds import Kind
from rosbase.messages import Time
from rosbase.messages import rcl_interfaces as msgs
from rosbase.wire import reader, writer
from rosbase_ros2.parameters import Overrides, RosParameters
from rosbase_ros2.questions import Questions
from rosbase_ros2.refusals import Refusals

__all__ = ["RecordedParameters"]


class RecordedParameters(RosParameters):
    """The parameters of one rclpy node, whose changes from outside are entries."""

    def __init__(
        self,
        node: Any,
        overrides: Overrides,
        questions: Questions,
        refusals: Refusals,
        report: Callable[[str], object],
        call_soon: Callable[[Callable[[], object]], object],
        conductor: Conductor,
        now_ns: Callable[[], int],
        call_urgently: Callable[[Callable[[], object]], object],
    ) -> None:
        """Take over checking parameters when they are set.

        Args:
            node: As for `RosParameters`.
            overrides: Likewise.
            questions: Likewise.
            refusals: Likewise.
            report: Likewise.
            call_soon: Likewise.
            conductor: The conductor of the program.
            now_ns: The clock of the node, whose readings are recorded.
            call_urgently: Queues a call for the main loop, also while that waits.
        """
        super().__init__(node, overrides, questions, refusals, report, call_soon)
        self._conductor, self._call_urgently = conductor, call_urgently
        self._name = node.get_fully_qualified_name().removeprefix("/")
        self._values: dict[str, Parameter[Any]] = {}
        node._parameter_event_publisher = _Events(
            node._parameter_event_publisher, conductor, now_ns
        )

    def declare(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare the parameter on the node, with its value from outside if there is one."""
        self._note_outside("declares a parameter")
        declared = self._values[spec.name] = super().declare(spec)
        return declared

    def get(self, name: str) -> Parameter[Any]:
        """Return the parameter with the value that the main loop knows."""
        known = self._values.get(name)
        if known is None:
            read = super().get
            value = found(self._conductor, lambda: read(name).value, value_to, value_from)
            return Parameter(name, value)
        # Whoever changes the list would get around the checks.
        return Parameter(name, list(known.value)) if isinstance(known.value, list) else known

    def names(self) -> list[str]:
        """Return the names of all parameters of the node."""
        return list(found(self._conductor, super().names))

    def set(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused. Call it on the main loop."""
        self._note_outside("sets parameters")
        theirs = [one.name for one in parameters if self._rules.find(one.name) is None]
        if any(self._node.has_parameter(name) for name in theirs):
            self._conductor.spoil(f"the program sets parameters of rclpy: {', '.join(theirs)}")
        result = super().set(parameters)
        if result.successful and not theirs:
            self._store(self._rules.check(parameters))
        return result

    def _value_of(self, spec: ParameterSpec) -> Any:
        read = super()._value_of
        return found(self._conductor, lambda: read(spec), value_to, value_from)

    def _tell(self, parameters: list[Any]) -> None:
        # What others have set is told when the main loop has come to it.
        if not self._questions.is_foreign:
            super()._tell(parameters)

    def _check(self, parameters: list[Any]) -> Any:
        if not self._questions.is_foreign:
            return super()._check(parameters)
        try:
            checked = self._checked(parameters)
        except ParameterError as error:
            return RosResult(successful=False, reason=str(error))
        if not checked:
            return RosResult(successful=True)
        take = partial(self._take, checked)
        if not self._rules.has_callbacks:
            self._let_in(checked, take)
            return RosResult(successful=True)
        if reason := self._busy(checked):
            return RosResult(successful=False, reason=reason)
        answer = self._questions.ask(take, self._give_up, partial(self._let_in, checked))
        return RosResult(successful=bool(answer.successful), reason=answer.reason)

    def _let_in(self, checked: list[Parameter[Any]], call: Callable[[], object]) -> None:
        payload = parameters_to(self._name, checked)
        self._conductor.come_in(Kind.PARAM, (), payload, partial(self._call_urgently, call))

    def _take(self, checked: list[Parameter[Any]]) -> SetParametersResult:
        """Take the values, on the main loop, unless the program refuses them."""
        answer = SetParametersResult(successful=True)
        if self._rules.has_callbacks:
            answer = self._rules.ask(checked)
        if answer.successful:
            self._store(checked)
            self._call_soon(lambda: self._rules.tell(checked))
        return answer

    def _store(self, checked: Sequence[Parameter[Any]]) -> None:
        self._values |= {parameter.name: parameter for parameter in checked}

    def _give_up(self, reason: str) -> SetParametersResult:
        self._conductor.spoil(f"parameters of {self._name}: {reason}")
        return refused(reason)

    def _note_outside(self, what: str) -> None:
        if not self._conductor.is_inside:
            self._conductor.spoil(f"a thread of the program's own {what}")


class _Events:
    """The publisher of parameter events, in place of rclpy's own.

    What the program changes has the date that it reads itself, and bytes without gaps, so that a
    replay publishes the same.
    """

    def __init__(self, inner: Any, conductor: Conductor, now_ns: Callable[[], int]) -> None:
        self._inner, self._conductor, self._now_ns = inner, conductor, now_ns
        self._read, self._write = reader(msgs.ParameterEvent), writer(msgs.ParameterEvent)

    def publish(self, event: ParameterEvent) -> None:
        """Publish an event."""
        if not self._conductor.is_inside:
            self._inner.publish(event)
            return
        stamp = Time.as_stamp(self._now_ns())
        event.stamp.sec, event.stamp.nanosec = stamp.sec, stamp.nanosec
        self._inner.publish(self._write(self._read(bytes(serialize_message(event)))))
