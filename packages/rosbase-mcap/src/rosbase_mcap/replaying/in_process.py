"""`replay()`: a recording as a test of a program."""

from collections.abc import Callable, Collection, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

from rosbase import BaseManager, BaseNode
from rosbase.contracts.message_format import find_type, message_format
from rosbase.errors import ConfigurationError
from rosbase.messages.lifecycle_msgs import TransitionEvent
from rosbase.messages.rcl_interfaces import Log, ParameterEvent
from rosbase.wire.plain import decoder
from rosbase_mcap.errors import McapError
from rosbase_mcap.log_channel import LOG_TOPIC
from rosbase_mcap.outputs import Output
from rosbase_mcap.records import Schema
from rosbase_mcap.replaying.options import ReplayOptions
from rosbase_mcap.replaying.session import Session
from rosbase_mcap.surroundings import differences, restored

__all__ = ["Replay", "replay"]

_PARAMETERS = "/parameter_events"
_TRANSITIONS = "/transition_event"
_NS_PER_S = 1_000_000_000


class Replay:
    """The output of a replayed program."""

    def __init__(
        self,
        session: Session,
        outputs: list[Output],
        difference: str,
        error: BaseException | None,
        kept: Collection[str] | None = None,
    ) -> None:
        outcome = session.outcome
        self._outputs, self._schemas = outputs, session.schemas
        self._start_ns = session.start_ns
        known = {*session.schemas, *session.recorded_topics}
        self._known = sorted(known if kept is None else known & set(kept))
        self.difference = difference
        """Where the program begins to differ from the recording, as lines for people; empty if it
        does not. Only a replay of all inputs is compared."""
        self.cut_short = outcome.cut_short
        """Why the recording could not be replayed to its end; empty if it was."""
        self.sha256 = outcome.sha256
        """SHA-256 of all messages, parameters and transitions, with their order."""
        self.error = error
        """Exception that has ended the program as it did in the recording; None if none did."""

    @property
    def topics(self) -> list[str]:
        """Full names of the topics with messages, sorted."""
        return sorted({output.topic for output in self._outputs})

    def topic(self, name: str) -> list[Any]:
        """Return the messages of a topic.

        Args:
            name: Its name; `/` in front may be left out.

        Raises:
            ConfigurationError: Neither the program nor the recording has such a topic, or its
                messages are not kept. The error names the topics.
        """
        return [message for _, message in self.stamped(name)]

    def stamped(self, name: str) -> list[tuple[float, Any]]:
        """Return the messages of a topic, each with its time in seconds since the start.

        Args:
            name: Its name; `/` in front may be left out.

        Raises:
            ConfigurationError: As for `topic`.
        """
        full = f"/{name.lstrip('/')}"
        if full not in self._known:
            known = ", ".join(self._known) or "none"
            raise ConfigurationError(f"no topic {full} in this replay; there are: {known}")
        return self._messages(full)

    def _messages(self, full: str) -> list[tuple[float, Any]]:
        schema = self._schemas.get(full)
        if schema is None:
            return []
        decode = _decoder(schema)
        return [
            ((output.log_ns - self._start_ns) / _NS_PER_S, decode(output.data))
            for output in self._outputs
            if output.topic == full
        ]

    @property
    def transitions(self) -> list[tuple[str, TransitionEvent]]:
        """Transitions of lifecycle nodes, each with the full name of its node."""
        decode = message_format(TransitionEvent).decode
        return [
            (output.topic.removesuffix(_TRANSITIONS), decode(output.data))
            for output in self._outputs
            if output.topic.endswith(_TRANSITIONS)
        ]

    @property
    def parameters(self) -> list[ParameterEvent]:
        """Declared and changed parameters."""
        return [message for _, message in self._messages(_PARAMETERS)]

    @property
    def log(self) -> list[Log]:
        """Lines of the log."""
        return [message for _, message in self._messages(LOG_TOPIC)]


def replay(
    path: str | Path,
    program: type[BaseManager] | type[BaseNode] | Callable[[], object],
    *,
    topics: Collection[str] | None = None,
    keep: Collection[str] | None = None,
) -> Replay:
    """Run a program in virtual time, fed from a recording, and return what it has published.

    It runs as fast as it can, on the calling thread. Its arguments, its parameters from outside
    and its log levels come from the recording.

    Args:
        path: The recording, or a bag of ROS.
        program: Class of a manager or standalone node, or a function that makes one and returns it,
            or that runs one.
        topics: Topics whose messages come from the recording, while all else comes from the
            program; empty for those that the program subscribes to. By default, all inputs of the
            recorded program are replayed; of a file that has none, topics.
        keep: Topics whose messages are kept in memory, for `Replay.topic`; by default all.

    Raises:
        McapError: The file cannot be read.
        ConfigurationError: It cannot be replayed in that way, or `program` is no program.
        BaseException: What ends the program, unless the same has ended the recorded one; that is
            `Replay.error`.
    """
    if not callable(program):
        raise ConfigurationError(f"{program!r} is no class and no function")
    names = None if topics is None else tuple(f"/{topic.lstrip('/')}" for topic in topics)
    wanted = None if keep is None else {f"/{topic.lstrip('/')}" for topic in keep}
    outputs: list[Output] = []

    def hear(output: Output) -> None:
        if wanted is None or output.topic in wanted:
            outputs.append(output)

    options = ReplayOptions(Path(path), names, rate=None)
    session = Session(options, hear, may_have_topics_only=True)
    facts = session.facts
    with nullcontext() if facts is None else restored(facts), session.conducting():
        error = _run(session, program)
    if not session.has_begun:
        raise ConfigurationError(f"{program!r} is no manager and no standalone node")
    found = session.outcome.difference
    difference = "" if found is None else str(found)
    reasons = _reasons(session, facts) if facts is not None and difference else []
    if reasons:
        difference += f"\nthis may be why: {'; '.join(reasons)}"
    return Replay(session, outputs, difference, error, wanted)


def _reasons(session: Session, facts: Mapping[str, Any]) -> list[str]:
    """Return why a replay may differ although the program is the same."""
    reasons = differences(facts, "")
    try:
        if session.run is not None:
            session.run.check_undamaged()
    except McapError as error:
        reasons.append(str(error))
    return reasons


def _run(session: Session, program: Any) -> BaseException | None:
    """Run the program; return the error that has ended it if it ended the recorded one too."""
    try:
        made = program()
        if isinstance(made, BaseManager):
            made.start_main_loop_timer()
        elif isinstance(made, BaseNode):
            made.start_spin_standalone()
    except SystemExit:
        return None
    except BaseException as error:
        end = session.run.end if session.run is not None else None
        if end is None or end.facts.ended_by != f"{type(error).__name__}: {error}":
            raise
        return error
    return None


def _decoder(schema: Schema) -> Callable[[bytes], Any]:
    """Return the function that reads messages of a topic: as rosbase's class, or as a dict."""
    try:
        decode: Callable[[bytes], Any] = message_format(find_type(schema.name)).decode
    except TypeError:
        return decoder(schema.name, str(schema.data, "utf-8"))
    return decode
