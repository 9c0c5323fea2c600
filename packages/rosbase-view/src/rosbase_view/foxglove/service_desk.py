"""Services of the programs, for clients that call them."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from attrs import frozen
from foxglove import MessageSchema, Schema, Service, ServiceRequest, ServiceSchema

from rosbase import ControlError
from rosbase.control.gathering import ask_one, gather
from rosbase.control.names import is_hidden
from rosbase.control.time_limit import TimeLimit
from rosbase_view.foxglove.channels import programs_of
from rosbase_view.foxglove.names import NameTable, candidates
from rosbase_view.foxglove.server import ENCODING, SCHEMA_ENCODING, Server
from rosbase_view.reports import Survey

__all__ = ["ServiceDesk"]

_ANSWER_S = 1.0
_CALL_S = 30.0


@frozen
class _Key:
    """A service of a process."""

    name: str
    type: str
    pid: int


class ServiceDesk:
    """Offers the services to clients, and calls them."""

    def __init__(self, server: Server) -> None:
        """Begin without services."""
        self._server = server
        self._names: NameTable[_Key] = NameTable()
        self._found: dict[_Key, list[str]] = {}
        self._offered: dict[str, _Key] = {}
        self._silent_until: dict[str, TimeLimit] = {}
        self._faulty: set[_Key] = set()

    def update(self, survey: Survey) -> dict[str, list[str]]:
        """Offer what runs; return the nodes of each service, by the name that clients see."""
        found = self._found = self._ask(survey)
        programs = programs_of(survey)
        names = self._names.update(
            {key: candidates(key.name, programs[key.pid], key.pid) for key in found}
        )
        for name, key in list(self._offered.items()):
            if names.get(name) != key:
                del self._offered[name]
                self._server.remove_service(name)
        self._faulty &= found.keys()
        for name, key in names.items():
            if name not in self._offered and key not in self._faulty:
                self._offer(name, key)
        return {name: found[key] for name, key in self._offered.items()}

    def _ask(self, survey: Survey) -> dict[_Key, list[str]]:
        """Return the nodes of each service that runs."""
        pids = {process["pid"] for process in survey.processes}
        asked = pids - survey.silent
        replies = (
            gather([("service.list", {})], _ANSWER_S, asked, None, self._silent_until)
            if asked
            else []
        )
        silent = pids - {reply.pid for reply in replies}
        # A program that does not answer keeps its services as long as it is there.
        kept = {key: nodes for key, nodes in self._found.items() if key.pid in silent}
        return kept | {
            _Key(service["name"], service["type"], reply.pid): service["servers"]
            for reply in replies
            if not isinstance(reply.answers[0], ControlError)
            for service in reply.answers[0]["services"]
            if service["servers"] and not is_hidden(service["name"])
        }

    def _offer(self, name: str, key: _Key) -> None:
        arguments = {"service": key.name, "type": key.type}
        try:
            about = ask_one(key.pid, "service.type", arguments, wait_s=_ANSWER_S)[0]
        except ControlError as error:
            if error.kind == "failed":
                # It has no type of ROS, so no client can call it.
                self._faulty.add(key)
            return
        schema = ServiceSchema(
            key.type, request=_part(about["request"]), response=_part(about["response"])
        )
        self._server.add_service(Service(name, schema=schema, handler=partial(_call, key)))
        self._offered[name] = key


def _part(about: Mapping[str, Any]) -> MessageSchema:
    text: str = about["schema"]
    schema = Schema(name=about["type"], encoding=SCHEMA_ENCODING, data=text.encode())
    return MessageSchema(encoding=ENCODING, schema=schema)


def _call(key: _Key, request: ServiceRequest) -> bytes:
    """Call a service. The SDK has a thread for each call, and sends the error.

    Raises:
        CallFailedError: The call failed, or there is no response in time.
    """
    arguments = {"service": key.name, "type": key.type, "timeout_ns": int(_CALL_S * 1e9)}
    try:
        return ask_one(key.pid, "service.call", arguments, request.payload, _CALL_S + 1.0)[1]
    except ControlError as error:
        raise CallFailedError(str(error)) from None


class CallFailedError(Exception):
    """A call has failed. The SDK sends the name of the class to the client, before the text."""


CallFailedError.__name__ = CallFailedError.__qualname__ = "the call failed"
