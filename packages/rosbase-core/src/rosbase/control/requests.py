"""Requests of clients, and how they are answered: now, later, or with a stream of events."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

from rosbase.errors import ControlError
from rosbase.text.printable import one_line

if TYPE_CHECKING:
    from rosbase.control.session import Session
    from rosbase.control.streams import Stream
    from rosbase.runtime.executor import Description

__all__ = [
    "DEFAULT_TIMEOUT_NS",
    "LATER",
    "Answerer",
    "Later",
    "Reply",
    "Request",
    "control_entry",
]

ValueT = TypeVar("ValueT")

DEFAULT_TIMEOUT_NS = 5_000_000_000
"""How long an answer may take that another thread gives."""
_MOST_TIMEOUT_NS = 3_600_000_000_000


class Later:
    """Type of `LATER`."""


LATER: Final = Later()
"""Reply of an answerer that will call `request.answer` or `request.fail`."""

Reply: TypeAlias = "dict[str, Any] | tuple[dict[str, Any], bytes] | Stream | Later"
"""Return value of an answerer; see `rosbase.control.answers`."""
Answerer: TypeAlias = "Callable[[Session, Request], Reply]"
"""Function that answers a request; see `rosbase.control.answers`."""


class Request:
    """One request of a client. It is answered once; later answers are ignored.

    The methods that read arguments raise ControlError of kind `invalid`, which answers the
    request.
    """

    __slots__ = (
        "_on_timeout",
        "_session",
        "_unanswered",
        "arguments",
        "ask",
        "data",
        "deadline_ns",
        "id",
    )

    def __init__(
        self, session: "Session", number: int, ask: str, arguments: dict[str, Any], data: bytes
    ) -> None:
        self._session = session
        self.id = number
        self.ask = ask
        """Name of the request, such as `topic.list`."""
        self.arguments = arguments
        """All that its line has."""
        self.data = data
        """Bytes behind its line."""
        self.deadline_ns: int | None = None
        """When it is answered with a timeout, on the monotonic clock."""
        self._on_timeout: Callable[[], str] = str
        # Whoever takes the entry may answer; to pop is one step, whatever other threads do.
        self._unanswered = [True]

    def text(self, name: str, default: str | None = None) -> str:
        """Return an argument that is a text."""
        return self._typed(name, str, "a text", default)

    def flag(self, name: str, *, default: bool | None = None) -> bool:
        """Return an argument that is true or false."""
        return self._typed(name, bool, "true or false", default)

    def whole(self, name: str, default: int | None = None, least: int = 0) -> int:
        """Return an argument that is a whole number."""
        value = self._typed(name, int, "a whole number", default)
        if value < least:
            raise ControlError(f"{name} is at least {least}, not {value}", "invalid")
        return value

    def texts(self, name: str) -> list[str] | None:
        """Return an argument that is a list of texts; None if it is absent."""
        value = self.arguments.get(name)
        if value is None:
            return None
        if not (isinstance(value, list) and all(isinstance(item, str) for item in value)):
            raise ControlError(f"{name} is a list of texts", "invalid")
        return value

    def answer(self, ok: dict[str, Any], data: bytes = b"") -> bool:
        """Answer the request. Call it from any thread.

        Returns:
            False if it has been answered already, such as with a timeout.
        """
        return self._settle({"ok": ok}, data)

    def fail(self, error: ControlError) -> bool:
        """Answer the request with an error, as `answer`."""
        return self._settle(error_frame(error))

    def describe(self) -> "Description":
        """Return what a recording has of the request, for `Executor.call_from_outside`."""
        return control_entry(self._session, self.arguments, self.data)

    def wait(
        self,
        on_timeout: Callable[[], str] = str,
        timeout_ns: int = DEFAULT_TIMEOUT_NS,
        grace_ns: int = 0,
    ) -> Later:
        """Return `LATER`, and have the request fail if nobody has answered in time.

        For an answerer. The argument `timeout_ns` of the request counts, if there is one.

        Args:
            on_timeout: Called on the thread of the socket when the time is up. It gives up the
                work, and returns the text of the error.
            timeout_ns: The time, if the request does not say it.
            grace_ns: Time in addition, for whoever ends the work in time by itself.
        """
        asked_ns = self.whole("timeout_ns", timeout_ns)
        self._on_timeout = on_timeout
        self.deadline_ns = self._session.now_ns() + min(asked_ns + grace_ns, _MOST_TIMEOUT_NS)
        return LATER

    def time_out(self) -> None:
        """Fail because the time is up. Called on the thread of the socket."""
        text = self._on_timeout() or f"{self.ask} took too long"
        self.fail(ControlError(text, "timeout"))

    def _settle(self, frame: dict[str, Any], data: bytes = b"") -> bool:
        try:
            self._unanswered.pop()
        except IndexError:
            return False
        self._session.answered(self, {"id": self.id, **frame}, data)
        return True

    def _typed(self, name: str, kind: type[ValueT], what: str, default: ValueT | None) -> ValueT:
        value = self.arguments.get(name)
        if value is None:
            if default is None:
                raise ControlError(f"{self.ask} needs {name}, {what}", "invalid")
            return default
        # No bool is a whole number here.
        if type(value) is not kind:
            raise ControlError(f"{name} is {what}, not {type(value).__name__}", "invalid")
        return value


def control_entry(session: "Session", arguments: dict[str, Any], data: bytes) -> "Description":
    """Return what a recording has of something that a connection asks.

    Args:
        session: The connection.
        arguments: What it asks, as JSON has it.
        data: Bytes behind that.
    """
    # Most programs are not recorded.
    from rosbase.entries.kinds import Kind
    from rosbase.entries.payloads import to_json

    return Kind.CONTROL, (session.number,), b"%s\n%s" % (to_json(arguments), data)


def error_frame(error: ControlError) -> dict[str, Any]:
    """Return the part of a frame that tells an error, in one line."""
    frame: dict[str, Any] = {"error": one_line(str(error)), "kind": error.kind}
    if error.suggestions:
        frame["suggestions"] = error.suggestions
    return frame
