"""Connections that pass on the parameters of their node to a store."""

from collections.abc import Sequence
from typing import Any, Protocol

from rosbase.contracts.node_connection import NodeConnection
from rosbase.contracts.parameter_store import OnSetParameters, PostSetParameters
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult

__all__ = ["KeepsParameters", "StoredParameters"]


class KeepsParameters(Protocol):
    """The methods of a store that a connection uses."""

    def declare(self, spec: ParameterSpec, /) -> Parameter[Any]:
        """Declare a parameter."""
        ...

    def get(self, name: str, /) -> Parameter[Any]:
        """Return a parameter with its value."""
        ...

    def set(self, parameters: Sequence[Parameter[Any]], /) -> SetParametersResult:
        """Set all parameters, or none."""
        ...

    def names(self) -> list[str]:
        """Return the names of the parameters."""
        ...

    def describe(self, name: str, /) -> ParameterSpec:
        """Return the declaration of a parameter."""
        ...

    def add_callback(self, callback: OnSetParameters, /) -> None:
        """Ask a callback before parameters are set."""
        ...

    def add_post_callback(self, callback: PostSetParameters, /) -> None:
        """Call a callback after parameters were set."""
        ...


class StoredParameters(NodeConnection):
    """The parameter methods of a connection, passed on to `_parameters`."""

    _parameters: KeepsParameters

    def declare_parameter(self, spec: ParameterSpec) -> Parameter[Any]:
        """Declare a parameter, with its override if there is one."""
        return self._parameters.declare(spec)

    def get_parameter(self, name: str) -> Parameter[Any]:
        """Return the parameter with its current value, also if others have set it."""
        return self._parameters.get(name)

    def set_parameters(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused."""
        return self._parameters.set(parameters)

    def parameter_names(self) -> list[str]:
        """Return the names of the node's parameters."""
        return self._parameters.names()

    def describe_parameter(self, name: str) -> ParameterSpec:
        """Return the declaration of a parameter."""
        return self._parameters.describe(name)

    def add_on_set_parameters_callback(self, callback: OnSetParameters) -> None:
        """Ask `callback` before parameters are set, from any source."""
        self._parameters.add_callback(callback)

    def add_post_set_parameters_callback(self, callback: PostSetParameters) -> None:
        """Call `callback` after parameters were set, from any source."""
        self._parameters.add_post_callback(callback)
