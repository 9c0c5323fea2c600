"""What is wrong with parameters."""

from attrs import evolve

from rosbase.contracts.backend import BackendOptions
from rosbase.errors import ParameterError
from rosbase.local import LocalBackend
from rosbase.parameters import Parameter, ParameterSpec
from support.backend_mutants.changed import breaks


@breaks("parameters-keep-their-kind")
class HasTextsOnly(LocalBackend):
    def get_parameter(self, name: str) -> Parameter:
        return Parameter(name, str(super().get_parameter(name).value))


@breaks("overrides-win")
class HeedsNoOverride(LocalBackend):
    def __init__(self, options: BackendOptions) -> None:
        super().__init__(evolve(options, parameter_overrides={}))


@breaks("overrides-win")
@breaks("wrong-overrides-are-errors")
class TakesAnyOverride(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        value = self._options.parameter_overrides.get(spec.name, spec.default)
        return self._parameters.setdefault(spec.name, Parameter(spec.name, value))


@breaks("wrong-overrides-are-errors")
class DeclaresWhatItRefuses(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        try:
            return super().declare_parameter(spec)
        except ParameterError:
            self._parameters[spec.name] = Parameter(spec.name, spec.default)
            raise


@breaks("declaring-twice-is-an-error")
class RefusesTheFirst(DeclaresWhatItRefuses):
    pass


@breaks("declaring-twice-is-an-error")
class DeclaresTheLast(LocalBackend):
    def declare_parameter(self, spec: ParameterSpec) -> Parameter:
        self._parameters.pop(spec.name, None)
        return super().declare_parameter(spec)


@breaks("undeclared-parameters-are-errors")
class KnowsEveryParameter(LocalBackend):
    def get_parameter(self, name: str) -> Parameter:
        return self._parameters.get(name, Parameter(name, ""))


@breaks("undeclared-parameters-are-errors")
class TellsAtLength(LocalBackend):
    def get_parameter(self, name: str) -> Parameter:
        try:
            return super().get_parameter(name)
        except ParameterError as error:
            raise ParameterError(f"{error}\n(declare it first)") from None
