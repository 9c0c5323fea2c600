"""The parameters of a backend: declared once, checked whenever they are set."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol, TypeAlias

from rosbase.errors import ParameterError
from rosbase.logger import RosbaseLogger
from rosbase.parameters import (
    Parameter,
    ParameterSpec,
    ParameterValue,
    SetParametersResult,
    check_value,
    did_you_mean,
)
from rosbase.text.printable import one_line

__all__ = [
    "OnSetParameters",
    "ParameterListener",
    "ParameterRules",
    "ParameterStore",
    "PostSetParameters",
    "name_undeclared",
    "refused",
]

OnSetParameters: TypeAlias = Callable[[list[Parameter[Any]]], Any]
"""Callback that returns a `SetParametersResult`, or rclpy's, for parameters about to be set."""


PostSetParameters: TypeAlias = Callable[[list[Parameter[Any]]], object]
"""Callback for parameters that have been set."""


class ParameterListener(Protocol):
    """Function that hears of parameters that were declared or set."""

    def __call__(self, parameters: Sequence[Parameter[Any]], /, *, are_new: bool) -> object:
        """Take the parameters; they are new if they have just been declared."""
        ...


class ParameterRules:
    """Rules for the values of each declared parameter, and callbacks that may refuse a change."""

    def __init__(self, report: Callable[[str], object] | None = None) -> None:
        """Start without a parameter.

        Args:
            report: Called with a line for each callback that raises, or answers with no result;
                by default it is logged as an error.
        """
        self._report = report or RosbaseLogger("parameters").error
        self._specs: dict[str, ParameterSpec] = {}
        self._callbacks: list[OnSetParameters] = []
        self._post_callbacks: list[PostSetParameters] = []

    def add(self, spec: ParameterSpec) -> None:
        """Add a declared parameter."""
        self._specs[spec.name] = spec

    def find(self, name: str) -> ParameterSpec | None:
        """Return the declaration of a parameter; None if it was not declared."""
        return self._specs.get(name)

    def describe(self, name: str) -> ParameterSpec:
        """Return the declaration of a parameter.

        Raises:
            ParameterError: It has not been declared.
        """
        if (spec := self.find(name)) is None:
            raise ParameterError(f"parameter {name} has not been declared")
        return spec

    @property
    def has_callbacks(self) -> bool:
        """Whether any callback is asked before parameters are set."""
        return bool(self._callbacks)

    def add_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` before parameters are set; the last one added is asked first."""
        self._callbacks.insert(0, callback)

    def add_post_callback(self, callback: PostSetParameters) -> None:
        """Call `callback` after parameters were set."""
        self._post_callbacks.append(callback)

    def tell(self, parameters: Sequence[Parameter[Any]]) -> None:
        """Tell the callbacks of parameters that were set. Call it on the spinning thread."""
        for callback in list(self._post_callbacks):
            if own := self._of(callback, parameters):
                try:
                    callback(own)
                except Exception as error:
                    # Somebody else has set them: that must not end the program.
                    name, kind = _name_of(callback), type(error).__name__
                    self._report(one_line(f"the parameter callback {name} raised {kind}: {error}"))

    def check(self, parameters: Sequence[Parameter[Any]]) -> list[Parameter[Any]]:
        """Return the parameters as values of their declared types.

        Raises:
            ParameterError: One is undeclared, read-only or has a value of another type.
        """
        checked: list[Parameter[Any]] = []
        for parameter in parameters:
            spec = self._specs.get(parameter.name)
            if spec is None:
                raise ParameterError(f"parameter {parameter.name} has not been declared")
            if spec.read_only:
                raise ParameterError(f"parameter {spec.name} is read-only")
            checked.append(Parameter(spec.name, check_value(spec, parameter.value)))
        return checked

    def ask(self, checked: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Ask the callbacks, on the spinning thread; the first refusal counts.

        A callback that raises, or answers with no result, is reported and counts as a refusal.
        """
        for callback in list(self._callbacks):
            own = self._of(callback, checked)
            if not own:
                continue
            try:
                answer = callback(own)
            except Exception as error:
                return self._fault(callback, f"raised {type(error).__name__}: {error}")
            if isinstance(answer, type) or getattr(answer, "successful", None) is None:
                return self._fault(callback, f"must return a SetParametersResult, not {answer!r}")
            if not answer.successful:
                return refused(str(getattr(answer, "reason", "")) or "the program refuses it")
        return SetParametersResult(successful=True)

    def _of(self, callback: object, parameters: Sequence[Parameter[Any]]) -> list[Parameter[Any]]:
        """Return the parameters of the node whose callback it is: other nodes may share them."""
        prefix = getattr(callback, "prefix", "")
        return [p for p in parameters if self.prefix_of(p.name) == prefix]

    def prefix_of(self, name: str) -> str:
        """Return the beginning of a name that stands for its node; empty if there is none."""
        spec = self._specs.get(name)
        return name.removesuffix(spec.general_name) if spec and spec.general_name else ""

    def _fault(self, callback: OnSetParameters, fault: str) -> SetParametersResult:
        reason = one_line(f"the parameter callback {_name_of(callback)} {fault}")
        self._report(f"parameters are refused: {reason}")
        return refused(reason)


class ParameterStore(ParameterRules):
    """Declared parameters with their values."""

    def __init__(
        self,
        overrides: Mapping[str, ParameterValue],
        report: Callable[[str], object] | None = None,
        call_soon: Callable[[Callable[[], object]], object] | None = None,
    ) -> None:
        """Start without a parameter.

        Args:
            overrides: Values that override the defaults of the parameters declared later.
            report: As for `ParameterRules`.
            call_soon: Queues a call for the spinning thread; by default it is made at once.
        """
        super().__init__(report)
        self._call_soon = call_soon or (lambda call: call())
        self._overrides = overrides
        self._general_names: set[str] = set()
        self._values: dict[str, Parameter[Any]] = {}
        self._listeners: list[ParameterListener] = []

    def add_listener(self, listener: ParameterListener) -> None:
        """Call `listener` after each change, on the thread that makes it."""
        self._listeners.append(listener)

    def declare(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare a parameter, with its override if there is one.

        Raises:
            ParameterError: It is declared already, or the override is not a valid value.
        """
        if not (isinstance(spec.name, str) and spec.name):
            raise ParameterError(f"a parameter has a name of at least one character: {spec.name!r}")
        if self.find(spec.name) is not None:
            raise ParameterError(f"parameter {spec.name} is declared twice")
        given = self._overrides.get(spec.general_name, spec.default)
        value = check_value(spec, self._overrides.get(spec.name, given))
        self.add(spec)
        self._general_names.add(spec.general_name)
        declared = self._values[spec.name] = Parameter(spec.name, value)
        self._notify([declared], are_new=True)
        return declared

    def name_undeclared(self, warn: Callable[[str], object]) -> None:
        """Warn of overrides for parameters that were never declared."""
        given = [name for name in self._overrides if name not in self._general_names]
        name_undeclared(given, self._values, warn)

    def get(self, name: str) -> Parameter[Any]:
        """Return the parameter with its current value.

        Raises:
            ParameterError: It has not been declared.
        """
        try:
            found = self._values[name]
        except KeyError:
            raise ParameterError(f"parameter {name} has not been declared") from None
        # Whoever changes the list would get around the checks.
        return Parameter(name, list(found.value)) if isinstance(found.value, list) else found

    def names(self) -> list[str]:
        """Return the names of all parameters, in the order of declaration."""
        return list(self._values)

    def set(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused."""
        try:
            checked = self.check(parameters)
        except ParameterError as error:
            return refused(str(error))
        result = self.ask(checked)
        if result.successful:
            self._values |= {parameter.name: parameter for parameter in checked}
            self._notify(checked, are_new=False)
            self._call_soon(lambda: self.tell(checked))
        return result

    def _notify(self, parameters: Sequence[Parameter[Any]], *, are_new: bool) -> None:
        for listener in self._listeners:
            listener(parameters, are_new=are_new)


def name_undeclared(
    given: Iterable[str], declared: Iterable[str], warn: Callable[[str], object]
) -> None:
    """Warn of parameters that are given to a node but that it never declared.

    Args:
        given: The names of the parameters that are given.
        declared: The names of those that the node has.
        warn: Called with a line for each.
    """
    known = set(declared)
    for name in sorted(set(given) - known):
        # A node of a manager has its name in front of its parameters.
        longer = sorted(one for one in known if one.endswith(f".{name}"))
        hint = f"; did you mean {longer[0]}?" if longer else did_you_mean(name, known)
        warn(f"parameter {name} is set from outside, but this node does not declare it{hint}")


def _name_of(callback: object) -> str:
    return str(getattr(callback, "__qualname__", repr(callback)))


def refused(reason: str) -> SetParametersResult:
    """Return the result for a change that is refused."""
    return SetParametersResult(successful=False, reason=reason)
