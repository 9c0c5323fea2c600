"""The parameters of one node, of all that a backend keeps in one store."""

from collections.abc import Collection, Sequence
from typing import Any

from attrs import frozen

from rosbase.contracts.parameter_store import ParameterStore, refused
from rosbase.parameters import Parameter, ParameterSpec, SetParametersResult

__all__ = ["NodeParameters"]


@frozen
class NodeParameters:
    """The parameters of one node, by the names that other programs see."""

    store: ParameterStore
    prefix: str = ""
    """Beginning of their names in the store, such as `camera.` for a lifecycle node."""
    prefixes: Collection[str] = ()
    """Prefixes of all nodes with services of their own. A node without one has all the rest."""

    def names(self) -> list[str]:
        """Return the names of all, in the order of declaration."""
        return [self.inner_name(full) for full in self.store.names() if self.has(full)]

    def inner_name(self, full: str) -> str:
        """Return the name of one of its parameters from that in the store."""
        return full.removeprefix(self.prefix)

    def has(self, full: str) -> bool:
        """Return whether a parameter of that name in the store is one of the node."""
        prefix = self.store.prefix_of(full)
        return prefix == self.prefix or not (self.prefix or prefix in self.prefixes)

    def find(self, name: str) -> ParameterSpec | None:
        """Return the declaration of a parameter; None if the node has none of that name."""
        full = self.prefix + name
        return self.store.find(full) if self.has(full) else None

    def value(self, name: str) -> Any:
        """Return the value of a parameter that the node has."""
        return self.store.get(self.prefix + name).value

    def set(self, parameters: Sequence[Parameter[Any]]) -> SetParametersResult:
        """Set all parameters, or none if one is refused. Call it on the spinning thread."""
        for parameter in parameters:
            if self.find(parameter.name) is None:
                return refused(f"parameter {parameter.name} has not been declared")
        outer = [Parameter(self.prefix + p.name, p.value) for p in parameters]
        return self.store.set(outer)
