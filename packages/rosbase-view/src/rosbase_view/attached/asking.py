"""Questions to one program about one node, and changes."""

from collections.abc import Mapping, Sequence
from typing import Any

from rosbase import ControlError
from rosbase.control.gathering import ask_one
from rosbase_view.reports import NodeKey, NodeReport, ParameterRow, Said
from rosbase_view.source import Change, SetParameter

__all__ = ["NodeAsker", "make_change"]

_ANSWER_S = 1.0
_TRANSITION_S = 30.0


class NodeAsker:
    """Asks for the parameters and the transitions of nodes."""

    def __init__(self) -> None:
        """Begin with nothing known."""
        # What parameters mean does not change while a node has the same ones.
        self._described: dict[NodeKey, tuple[Sequence[str], Mapping[str, Any]]] = {}

    def ask(self, node: NodeKey, *, has_lifecycle: bool) -> NodeReport:
        """Return what a node tells.

        Raises:
            ControlError: It has ended, or does not answer.
        """
        name, pid = node
        values = self._ask(pid, "parameter.get", name)["values"]
        names = sorted(values)
        before = self._described.get(node)
        if before is None or before[0] != names:
            answer = self._ask(pid, "parameter.describe", name, names=names)
            before = self._described[node] = (names, answer["descriptors"])
        offered = self._ask(pid, "lifecycle.get", name)["available"] if has_lifecycle else ()
        rows = [_row(one, values[one], before[1].get(one, {})) for one in names]
        return NodeReport(node, rows, [transition["label"] for transition in offered])

    @staticmethod
    def _ask(pid: int, ask: str, node: str, **arguments: Any) -> Any:
        return ask_one(pid, ask, {"node": node, **arguments}, wait_s=_ANSWER_S)[0]


def _row(name: str, value: Mapping[str, Any], about: Mapping[str, Any]) -> ParameterRow:
    return ParameterRow(
        name,
        value["type"],
        value["value"],
        about.get("description") or "",
        about.get("constraints") or "",
        bool(about.get("read_only")),
    )


def make_change(change: Change) -> Said:
    """Make a change, and return what became of it. Waits until the program has answered."""
    try:
        if isinstance(change, SetParameter):
            return _set(change)
        name, pid = change.node
        arguments = {
            "node": name,
            "transition": change.transition,
            "timeout_ns": int(_TRANSITION_S * 1e9),
        }
        result = ask_one(pid, "lifecycle.set", arguments, wait_s=_TRANSITION_S + 1.0)[0]
    except ControlError as error:
        return Said(str(error), is_error=True)
    if result["successful"]:
        return Said(f"{name} is {result['state']}")
    reason = f": {result['reason']}" if result.get("reason") else ""
    text = f"{change.transition} of {name} failed, it is {result['state']}{reason}"
    return Said(text, is_error=True)


def _set(change: SetParameter) -> Said:
    name, pid = change.node
    arguments = {"node": name, "values": {change.name: {"text": change.text}}, "atomically": False}
    result = ask_one(pid, "parameter.set", arguments)[0]["results"][change.name]
    if result["successful"]:
        return Said(f"{change.name} is set")
    return Said(f"{change.name} is not set: {result['reason']}", is_error=True)
