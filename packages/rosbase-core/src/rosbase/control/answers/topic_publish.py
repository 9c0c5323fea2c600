"""A publisher for clients, which lives as long as their connection."""

from functools import partial
from typing import Any

from rosbase.contracts.backend import Backend, Publisher
from rosbase.control.answers.ends import find_topic, format_of, program_for, type_class
from rosbase.control.on_loop import on_loop
from rosbase.control.programs import Program
from rosbase.control.requests import Reply, Request, control_entry
from rosbase.control.session import Session
from rosbase.errors import BackendError, ControlError, WireError
from rosbase.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

__all__ = ["CLOSE", "close_again", "publish"]

CLOSE = "topic.publish.close"
"""Name of the end of a publisher in a recording. No client asks for it."""

_KEPT = "topic.publish"
_MADE = "topic.publish.made"
_MOST_PUBLISHERS = 64


class _ClientPublisher:
    """A publisher, and the way from bytes to its messages."""

    def __init__(self, session: Session, backend: Backend, publisher: Publisher[Any], form: Any):
        self._session = session
        self._backend = backend
        self._publisher = publisher
        self._decode = form.decode
        # Called on the main loop alone, as in a replay, which finds it by its number.
        made: list[_ClientPublisher] = session.kept.setdefault(_MADE, [])
        self._number = len(made)
        made.append(self)

    def publish(self, data: bytes) -> dict[str, Any]:
        """Publish a message, if there is one; return how many subscriptions there are."""
        if data:
            try:
                is_taken = self._publisher.publish(self._decode(data)) is not False
            except (TypeError, ValueError, WireError) as error:
                raise ControlError(str(error)[:1000], "invalid") from None
            if not is_taken:
                raise ControlError(f"{self._publisher.topic}: the backend refused the message")
        # Not of every backend.
        return {"subscriptions": getattr(self._publisher, "subscription_count", None)}

    def close(self) -> None:
        """Destroy the publisher, on the main loop."""
        end = partial(self._backend.destroy_publisher, self._publisher)
        asked: dict[str, Any] = {"ask": CLOSE, "publisher": self._number}
        describe = partial(control_entry, self._session, asked, b"")
        self._backend.executor.call_from_outside(end, describe)


def close_again(session: Session, request: Request) -> None:
    """Close a publisher in a replay, as its client did."""
    session.kept[_MADE][request.whole("publisher")].close()


def publish(session: Session, request: Request) -> Reply:
    """Publish a message; the first of a topic creates the publisher."""
    name, wanted = request.text("topic"), request.text("type", "")
    program_name = request.text("program", "")
    profile = _profile(request.arguments.get("qos"))
    kept: dict[Any, _ClientPublisher] = session.kept.setdefault(_KEPT, {})
    key = (program_name, name, wanted, profile)
    if key in kept:
        return kept[key].publish(request.data)
    if len(kept) >= _MOST_PUBLISHERS:
        raise ControlError(f"{_MOST_PUBLISHERS} publishers of this connection are open", "refused")
    program, backend, type_name, kind = _target(program_name, name, wanted)
    kind = type_class(backend, type_name, kind)
    form = format_of(backend, type_name, kind)

    def create() -> dict[str, Any]:
        try:
            publisher = backend.create_publisher(kind, name, profile)
        except BackendError as error:
            raise ControlError(str(error), "invalid") from None
        made = _ClientPublisher(session, backend, publisher, form)
        session.call(partial(_keep, session, key, made))
        return made.publish(request.data)

    return on_loop(request, program, create)


def _keep(session: Session, key: Any, made: _ClientPublisher) -> None:
    kept = session.kept[_KEPT]
    if session.is_closed or key in kept:
        # The client has gone meanwhile, or has asked twice before the first answer.
        made.close()
        return
    kept[key] = made
    session.on_close(made.close)


def _target(program: str, name: str, wanted: str) -> tuple[Program, Backend, str, Any]:
    """Return where to publish, and the type: the type of the topic, if the topic exists."""
    if program:
        chosen, backend = program_for(program)
        if not wanted:
            raise ControlError("topic.publish of a program needs type, a text", "invalid")
        return chosen, backend, wanted, None
    try:
        topic = find_topic(name)
    except ControlError:
        if not wanted:
            raise
        chosen, backend = program_for("")
        return chosen, backend, wanted, None
    if wanted not in ("", topic.type_name):
        text = f"{topic.name} carries {topic.type_name}, not {wanted[:200]}"
        raise ControlError(text, "invalid")
    return topic.program, topic.backend, topic.type_name, topic.msg_type


def _profile(given: Any) -> QoSProfile:
    if given is None:
        return QoSProfile()
    if not isinstance(given, dict):
        raise ControlError("qos is an object", "invalid")
    policies: dict[str, Any] = {}
    for name, kind in (
        ("reliability", ReliabilityPolicy),
        ("durability", DurabilityPolicy),
        ("history", HistoryPolicy),
    ):
        text = given.get(name)
        if text is not None:
            if not isinstance(text, str) or text.upper() not in kind.__members__:
                words = ", ".join(one.lower() for one in kind.__members__)
                raise ControlError(f"qos.{name} is one of {words}", "invalid")
            policies[name] = kind[text.upper()]
    try:
        return QoSProfile(given.get("depth", 10), **policies)
    except ValueError as error:
        raise ControlError(f"qos: {error}", "invalid") from None
