"""Questions about parameters, and setting them."""

from __future__ import annotations

from rosbase.control.gathering import ask_one
from rosbase.control.questions.nodes import NodeQuestions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping
    from typing import Any

    from rosbase.control.shapes import ParameterDescription, SetResult

__all__ = ["ParameterQuestions"]


class ParameterQuestions(NodeQuestions):
    """Questions about parameters of nodes."""

    def parameter_names(self, node: str | None = None) -> dict[str, list[str]]:
        """Return the names of the parameters by node: of all nodes, or of one.

        Raises:
            ControlError: No program has the node, or several have.
        """
        if node is not None:
            full, pid = self._find_node(node)
            found = ask_one(pid, "parameter.list", {"node": full})[0]["nodes"]
            return {name: sorted(names) for name, names in found.items()}
        everything: dict[str, list[str]] = {}
        for _, answer in self._gather("parameter.list"):
            for name, names in answer["nodes"].items():
                everything[name] = sorted({*everything.get(name, ()), *names})
        return dict(sorted(everything.items()))

    def names_in_files(self, node: str) -> tuple[list[str], list[str]]:
        """Return the names of a node, and of its manager, in parameter files.

        The first one is the name for messages. Only a plain node, which is found by its key, has
        its parameters among those of its manager.

        Raises:
            ControlError: No program has the node, or several have.
        """
        nodes = self.nodes()
        known_as, pid = self._node_among(node, nodes)
        for one in nodes:
            if one["pid"] == pid and one["key"] == known_as:
                is_plain = one["name"] == one["program"]
                own = [f"/{known_as}"]
                return (own, [one["name"]]) if is_plain else ([one["name"], *own], [])
        return [known_as], []

    def get_parameters(self, node: str, names: Iterable[str] | None = None) -> dict[str, Any]:
        """Return the values of parameters by name: of all, or of some.

        Raises:
            ControlError: No program has the node, or the node has no such parameter.
        """
        return {name: one["value"] for name, one in self.typed_parameters(node, names).items()}

    def typed_parameters(
        self, node: str, names: Iterable[str] | None = None
    ) -> dict[str, dict[str, Any]]:
        """Return the values of parameters as `{"type": ..., "value": ...}` by name.

        Raises:
            ControlError: As from `get_parameters`.
        """
        full, pid = self._find_node(node)
        arguments: dict[str, Any] = {"node": full}
        if names is not None:
            arguments["names"] = list(names)
        values: dict[str, dict[str, Any]] = ask_one(pid, "parameter.get", arguments)[0]["values"]
        return values

    def describe_parameters(
        self, node: str, names: Iterable[str]
    ) -> dict[str, ParameterDescription]:
        """Return what parameters mean, by name.

        Raises:
            ControlError: As from `get_parameters`.
        """
        full, pid = self._find_node(node)
        arguments = {"node": full, "names": list(names)}
        answer = ask_one(pid, "parameter.describe", arguments)[0]
        found: dict[str, ParameterDescription] = answer["descriptors"]
        return found

    def set_parameters(
        self, node: str, values: Mapping[str, Any], *, atomically: bool = False
    ) -> dict[str, SetResult]:
        """Set parameters; return for each whether it was set, and why not.

        Args:
            node: Name of the node.
            values: Values by name. `{"text": "0.5"}` is a value as a user would write it, which
                the type of the parameter decides how to read.
            atomically: Set all of them or none.

        Raises:
            ControlError: No program has the node, or several have.
        """
        full, pid = self._find_node(node)
        arguments = {"node": full, "values": dict(values), "atomically": atomically}
        results: dict[str, SetResult] = ask_one(pid, "parameter.set", arguments)[0]["results"]
        return results
