"""What is wrong with parameters."""

from collections.abc import Sequence
from typing import Any

from attrs import evolve

from rosbase.contracts.backend import BackendOptions
from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.node_view import NodeView
from rosbase.contracts.parameter_store import OnSetParameters, PostSetParameters
from rosbase.errors import ParameterError
from rosbase.local import LocalBackend
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult
from support.backend_mutants.changed import breaks


@breaks("parameters-keep-their-kind")
class HasTextsOnly(LocalBackend):
    def get_parameter(self, name: str) -> Parameter[Any]:
        return Parameter(name, str(super().get_parameter(name).value))


@breaks("overrides-win")
class HeedsNoOverride(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(evolve(options, parameter_overrides={}))


@breaks("overrides-win")
@breaks("wrong-overrides-are-errors")
class TakesAnyOverride(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        value = self._options.parameter_overrides.get(spec.name, spec.default)
        parameter = Parameter(spec.name, value)
        return self._parameters._values.setdefault(spec.name, parameter)


@breaks("wrong-overrides-are-errors")
class DeclaresWhatItRefuses(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        try:
            return super().declare_parameter(spec)
        except ParameterError:
            self._parameters._values[spec.name] = Parameter(spec.name, spec.default)
            raise


@breaks("declaring-twice-is-an-error")
class RefusesTheFirst(DeclaresWhatItRefuses):
    pass


@breaks("declaring-twice-is-an-error")
class DeclaresTheLast(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        self._parameters._specs.pop(spec.name, None)
        return super().declare_parameter(spec)


@breaks("undeclared-parameters-are-errors")
class KnowsEveryParameter(LocalBackend):
    def get_parameter(self, name: str) -> Parameter[Any]:
        return self._parameters._values.get(name, Parameter(name, ""))


@breaks("undeclared-parameters-are-errors")
class TellsAtLength(LocalBackend):
    def get_parameter(self, name: str) -> Parameter[Any]:
        try:
            return super().get_parameter(name)
        except ParameterError as error:
            raise ParameterError(f"{error}\n(declare it first)") from None


@breaks("setting-keeps-the-declared-kind")
class SetsWhateverItIsGiven(LocalBackend):
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        self._parameters._values |= {parameter.name: parameter for parameter in parameters}
        return SetParametersResult(successful=True)


@breaks("setting-keeps-the-declared-kind")
class SetsNothing(LocalBackend):
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        return self._parameters.ask(self._parameters.check(parameters))


@breaks("what-cannot-be-set-is-refused-whole")
class SetsTheFirst(LocalBackend):
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        results = [self._parameters.set([parameter]) for parameter in parameters]
        return next((result for result in results if not result.successful), results[-1])


@breaks("what-cannot-be-set-is-refused-whole")
class SetsWhatIsReadOnly(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        return super().declare_parameter(evolve(spec, read_only=False))


@breaks("what-cannot-be-set-is-refused-whole")
class RefusesWithoutAReason(LocalBackend):
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        return evolve(super().set_parameters(parameters), reason="")


@breaks("a-callback-may-refuse-what-is-set")
class AsksNobody(LocalBackend):
    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        pass


@breaks("a-callback-may-refuse-what-is-set")
class AsksTooLate(LocalBackend):
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        self._parameters._values |= {parameter.name: parameter for parameter in parameters}
        return super().set_parameters(parameters)


@breaks("callbacks-hear-what-was-set")
class TellsNobody(LocalBackend):
    def add_post_set_parameters_callback(self, callback: PostSetParameters) -> None:
        pass


@breaks("callbacks-hear-what-was-set")
class TellsOfWhatItRefuses(LocalBackend):
    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        result = super().set_parameters(parameters)
        if not result.successful:
            self.call_soon(lambda: self._parameters.tell(parameters))
        return result


@breaks("parameters-are-listed")
class ListsThoseOfLifecycleNodes(LocalBackend):
    def parameter_names(self) -> list[str]:
        return self._parameters.names()


@breaks("parameters-are-listed")
class ListsThemSorted(LocalBackend):
    def parameter_names(self) -> list[str]:
        return sorted(super().parameter_names())


@breaks("parameters-are-listed")
class DescribesWithoutLimits(LocalBackend):
    def describe_parameter(self, name: str) -> ParameterSpec:
        return evolve(super().describe_parameter(name), minimum=None)


@breaks("parameters-are-listed")
class DescribesAnything(LocalBackend):
    def describe_parameter(self, name: str) -> ParameterSpec:
        return self._parameters.find(name) or ParameterSpec(name, 2)


@breaks("nodes-have-their-own-parameters")
class HasOneNode(LocalBackend):
    def open_node(self, name: str, *, is_lifecycle: bool) -> NodeConnection:
        return self


@breaks("nodes-have-their-own-parameters")
class TakesNothingForEveryNode(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        return super().declare_parameter(evolve(spec, general_name=""))


@breaks("nodes-have-their-own-parameters")
class AsksEveryNode(LocalBackend):
    def open_node(self, name: str, *, is_lifecycle: bool) -> NodeConnection:
        return _AskingView(self, name, is_lifecycle=is_lifecycle)


class _AskingView(NodeView):
    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        self._shared.add_on_set_parameters_callback(callback)
