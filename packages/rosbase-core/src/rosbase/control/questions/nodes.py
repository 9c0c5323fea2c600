"""Questions about nodes."""

from __future__ import annotations

from rosbase.control.gathering import ask_one
from rosbase.control.questions.base import Questions

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.shapes import Node, NodeInfo

__all__ = ["NodeQuestions"]


class NodeQuestions(Questions):
    """Questions about nodes: which there are, and what they have."""

    def nodes(self) -> list[Node]:
        """Return the nodes of all programs, by name and key."""
        found: list[Any] = [
            {**node, "pid": pid}
            for pid, answer in self._gather("node.list")
            for node in answer["nodes"]
        ]
        return sorted(found, key=lambda node: (node["name"], node["key"]))

    def node(self, name: str) -> NodeInfo:
        """Return the topics, services and other things of a node.

        Args:
            name: Its name, without the slash in front if you like, or the key of a plain node in
                its manager.

        Raises:
            ControlError: No program has it, or several have.
        """
        full, pid = self._find_node(name)
        answer: NodeInfo = ask_one(pid, "node.info", {"name": full})[0]
        return answer

    def _find_node(self, name: str) -> tuple[str, int]:
        """Return the name under which a program knows a node, and its pid."""
        return self._node_among(name, self.nodes())

    def _node_among(self, name: str, nodes: list[Node]) -> tuple[str, int]:
        owners: dict[str, list[int]] = {}
        keys: dict[str, list[int]] = {}
        for node in nodes:
            owners.setdefault(node["name"], []).append(node["pid"])
            if node["key"]:
                keys.setdefault(node["key"], []).append(node["pid"])
        full = name if name.startswith("/") else f"/{name}"
        if full not in owners and name in keys:
            return self._one("node", name, keys)
        # Of a key and a name that are alike, one is enough for a suggestion.
        others = {key: pids for key, pids in keys.items() if f"/{key}" not in owners}
        return self._one("node", name, {**others, **owners})
