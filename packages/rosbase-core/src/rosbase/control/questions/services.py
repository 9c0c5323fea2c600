"""Questions about services."""

from __future__ import annotations

from rosbase.control.gathering import ask_one
from rosbase.control.names import full_type
from rosbase.control.questions.base import Questions
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from rosbase.control.shapes import ServiceInfo

__all__ = ["PreparedService", "ServiceQuestions"]

_SPARE_S = 1.0


class PreparedService:
    """A service of a program, with what it takes to write requests and read responses."""

    def __init__(self, name: str, pid: int, kind: str) -> None:
        # Lists of services need none of it.
        from rosbase.wire.plain import decoder, encoder

        self.name = name
        self.pid = pid
        self.type = kind
        answer, _ = ask_one(pid, "service.type", {"service": name, "type": kind})
        self.request: dict[str, Any] = answer["request"]
        """Type and schema of the request."""
        self.response: dict[str, Any] = answer["response"]
        """Type and schema of the response."""
        self._encode = encoder(self.request["type"], self.request["schema"])
        self._decode = decoder(self.response["type"], self.response["schema"])

    def encode(self, request: Mapping[str, Any] | None) -> bytes:
        """Return a request as CDR.

        Raises:
            TypeError: A field has a value of the wrong kind.
            ValueError: There is an unknown field, or a value is out of its range.
        """
        return self._encode(request)

    def call(self, data: bytes, timeout_s: float) -> dict[str, Any]:
        """Send a request; return the fields of the response.

        Raises:
            ControlError: The call failed, or there is no response in time.
        """
        arguments = {
            "service": self.name, "type": self.type, "timeout_ns": int(timeout_s * 1e9)
        }  # fmt: skip
        # A little longer, so that the answer says why there is no response.
        _, answer = ask_one(self.pid, "service.call", arguments, data, timeout_s + _SPARE_S)
        return self._decode(answer)


class ServiceQuestions(Questions):
    """Questions about services, and calls of them."""

    def services(self) -> list[ServiceInfo]:
        """Return the services of all programs, by name."""
        found: list[Any] = [
            {**service, "pid": pid}
            for pid, answer in self._gather("service.list")
            for service in answer["services"]
        ]
        return sorted(found, key=lambda service: (service["name"], service["pid"]))

    def call(
        self,
        service: str,
        request: Mapping[str, Any] | None = None,
        *,
        service_type: str | None = None,
        timeout_s: float = 5.0,
    ) -> dict[str, Any]:
        """Call a service, and return the fields of its response.

        Args:
            service: Its name.
            request: The fields of the request; those left out have their defaults.
            service_type: Its type, if it must be this one.
            timeout_s: How long to wait for the response, in seconds.

        Raises:
            ControlError: No program has it, or the call failed.
            TypeError: A field of the request has a value of the wrong kind.
            ValueError: The request has an unknown field, or a value is out of its range.
        """
        prepared = self.prepare(service, service_type)
        return prepared.call(prepared.encode(request), timeout_s)

    def prepare(self, service: str, service_type: str | None = None) -> PreparedService:
        """Return a service that can be called several times.

        Raises:
            ControlError: No program has it.
        """
        return PreparedService(*self.find_service(service, service_type))

    def find_service(self, name: str, service_type: str | None) -> tuple[str, int, str]:
        """Return the full name of a service, the process that offers it, and its type.

        Raises:
            ControlError: No program offers it, several do, or it has another type.
        """
        services = [service for service in self.services() if service["servers"]]
        owners: dict[str, list[int]] = {}
        for one in services:
            owners.setdefault(one["name"], []).append(one["pid"])
        full, pid = self._one("service", name, owners)
        kind = next(s["type"] for s in services if (s["name"], s["pid"]) == (full, pid))
        if service_type is not None and full_type(service_type, "srv") != kind:
            raise ControlError(f"service {full} is of type {kind}, not {service_type}", "invalid")
        return full, pid, kind
