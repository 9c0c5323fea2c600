"""Where requests of other threads for standard services come into a recorded program."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

from rosbase.contracts.guarded_services import UnheardRequest
from rosbase.contracts.message_format import message_format
from rosbase.contracts.service_server import ServiceRequest
from rosbase.entries.conductor import Conductor
from rosbase.entries.entrance import Remaker
from rosbase.entries.kinds import NUMBERED, Kind
from rosbase.entries.payloads import from_json, to_json
from rosbase.entries.script import Entry
from rosbase.local.standard.catalog import class_of, standard_type

__all__ = ["StandardEntrance"]

Take: TypeAlias = Callable[[str, str, str, ServiceRequest], None]


class StandardEntrance:
    """The way into the program for all standard services of one backend.

    They have one number, because they are made only when the first request comes.
    """

    def __init__(self, conductor: Conductor, take: Take) -> None:
        """Number the services.

        Args:
            conductor: The conductor of the program.
            take: Takes a request inside: node, kind and name of the service, request.
        """
        self._conductor = conductor
        self._take = take
        self._remakers: dict[tuple[str, str], Remaker] = {}
        text = "standard services"
        self._number = conductor.number(NUMBERED[Kind.REQUEST], text, self._replay)

    @property
    def is_inside(self) -> bool:
        """Whether the calling thread runs the program, so that nothing has to come in."""
        return self._conductor.is_inside

    def let_in(self, node: str, kind: str, service: str, call: ServiceRequest) -> None:
        """Have a request of another thread come in, as an entry."""
        data, call.request = self._remaker(kind, service).remake(call.request)
        payload = b"%s\n%s" % (to_json([node, kind, service]), data)
        take = partial(self._take, node, kind, service, call)
        self._conductor.come_in(Kind.REQUEST, (self._number,), payload, take)

    def _replay(self, entry: Entry) -> None:
        line, _, data = entry.payload.partition(b"\n")
        where: Any = from_json(line)
        node, kind, service = where
        request = self._remaker(kind, service).make(data)
        self._take(node, kind, service, UnheardRequest(request))

    def _remaker(self, kind: str, service: str) -> Remaker:
        key = kind, service
        if key not in self._remakers:
            find_form = partial(_request_form, kind, service)
            self._remakers[key] = Remaker(self._conductor, service, find_form)
        return self._remakers[key]


def _request_form(kind: str, service: str) -> Any:
    srv_type: Any = class_of(standard_type(kind, service))
    return message_format(srv_type.Request)
