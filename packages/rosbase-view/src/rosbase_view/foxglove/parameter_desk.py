"""Parameters of the programs' nodes, for clients that read and write them."""

import threading
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import partial
from typing import Any

from attrs import frozen
from foxglove import Parameter

from rosbase import ControlError
from rosbase.control.gathering import ask_one, gather
from rosbase.control.time_limit import TimeLimit
from rosbase_view.foxglove.names import NameTable, candidates
from rosbase_view.foxglove.notices import Notices
from rosbase_view.foxglove.server import Server
from rosbase_view.foxglove.values import from_parameter, to_parameter
from rosbase_view.foxglove.worker import Worker
from rosbase_view.reports import NodeKey, Survey

__all__ = ["ParameterDesk"]

# Meanwhile, the thread of the SDK that asks sends no messages to anybody. What takes longer is sent
# when it is known.
_PATIENCE_S = 0.05
_ANSWER_S = 1.0
_MOST_WAITING = 100


@frozen
class _Value:
    kind: str
    value: Any


class ParameterDesk:
    """Reads and writes parameters, named after the node and the parameter: `/arm.speed`.

    Values are asked for when a client asks, and once a second while one has subscribed to changes.
    """

    def __init__(
        self, server: Server, notices: Notices, on_failure: Callable[[Exception], object]
    ) -> None:
        """Begin without nodes.

        Args:
            server: Where changes are sent.
            notices: Takes the reasons why values were refused.
            on_failure: Takes an error that should not happen.
        """
        self._server, self._notices = server, notices
        self._worker = Worker("rosbase view parameters", _MOST_WAITING, on_failure)
        self._names: NameTable[NodeKey] = NameTable()
        self._nodes: Mapping[str, NodeKey] = {}
        self._silent_until: dict[str, TimeLimit] = {}
        self._lock = threading.Lock()
        self._values: dict[str, _Value] = {}
        self._subscribed: set[str] = set()

    def start(self) -> None:
        """Start the thread that asks."""
        self._worker.start()

    def close(self) -> None:
        """End the thread."""
        self._worker.close()

    def update(self, survey: Survey) -> None:
        """Take what runs."""
        # Plain nodes have their parameters on their manager, as in ROS.
        nodes = self._names.update(
            {
                node.key: candidates(node.key[0], node.program, node.key[1])
                for node in survey.nodes
                if node.key[0].startswith("/")
            }
        )
        is_new = nodes != self._nodes
        self._nodes = nodes
        if is_new or self._subscribed:
            self._worker.add(self._refresh)

    def get(self, names: Sequence[str]) -> list[Parameter]:
        """Return the values of parameters; of all of them if there are no names."""
        self._do(self._refresh)
        return self._parameters(names)

    def set(self, parameters: Sequence[Parameter]) -> list[Parameter]:
        """Set parameters; return their values, which are the new ones unless it takes long."""
        if not self._do(partial(self._write, list(parameters))):
            self._notices.say("parameters", "parameters are set too fast: some are left out")
        return self._parameters([one.name for one in parameters])

    def subscribe(self, names: Sequence[str]) -> None:
        """Tell of changes of these."""
        with self._lock:
            self._subscribed.update(names)

    def unsubscribe(self, names: Sequence[str]) -> None:
        """Tell of changes of these no more."""
        with self._lock:
            self._subscribed.difference_update(names)

    def _do(self, work: Callable[[], object]) -> bool:
        """Have something done, and wait a moment; return whether it is or will be done."""
        job = self._worker.add(work)
        if job is not None:
            job.wait(_PATIENCE_S)
        return job is not None

    def _parameters(self, names: Sequence[str]) -> list[Parameter]:
        with self._lock:
            values = self._values
        # A set of names that are all unknown is not empty, and has no parameters.
        return [
            to_parameter(name, values[name].kind, values[name].value)
            for name in names or values
            if name in values
        ]

    # On the thread that asks.

    def _refresh(self) -> None:
        """Ask for all values, and send those that have changed."""
        nodes = self._nodes
        values: dict[str, _Value] = {}
        for pid in {pid for _, pid in nodes.values()}:
            own = {name: key for name, key in nodes.items() if key[1] == pid}
            asks = [("parameter.get", {"node": node}) for node, _ in own.values()]
            replies = gather(asks, _ANSWER_S, [pid], None, self._silent_until)
            if not replies:
                # It does not answer; if it has ended, the next survey takes its nodes away.
                values |= self._values_of(own)
            for reply in replies:
                for node, answer in zip(own, reply.answers, strict=True):
                    if isinstance(answer, ControlError):
                        # It has gone since the survey.
                        continue
                    for name, one in answer["values"].items():
                        values[f"{node}.{name}"] = _Value(one["type"], one["value"])
        with self._lock:
            before, self._values = self._values, values
            changed = [
                name
                for name in self._subscribed & values.keys()
                if before.get(name) != values[name]
            ]
        self._server.send_parameters(self._parameters(changed) if changed else [])

    def _values_of(self, nodes: Collection[str]) -> dict[str, "_Value"]:
        """Return the values that the nodes had at last."""
        return {name: one for name, one in self._values.items() if name.partition(".")[0] in nodes}

    def _write(self, parameters: Sequence[Parameter]) -> None:
        for parameter in parameters:
            self._notices.end("parameters")
            about = f"parameter {parameter.name}"
            reason = self._write_one(parameter)
            if reason is None:
                self._notices.end(about)
            else:
                self._notices.say(about, f"{parameter.name} is not set: {reason}")
        self._refresh()

    def _write_one(self, parameter: Parameter) -> str | None:
        """Set a parameter; return the reason if it is not set."""
        # No name of a node has a dot.
        node, _, name = parameter.name.partition(".")
        key = self._nodes.get(node)
        if key is None:
            return "no program has such a parameter"
        arguments = {
            "node": key[0],
            "values": {name: from_parameter(parameter)},
            "atomically": False,
        }
        try:
            result = ask_one(key[1], "parameter.set", arguments)[0]["results"][name]
        except ControlError as error:
            return str(error)
        return None if result["successful"] else str(result["reason"])
