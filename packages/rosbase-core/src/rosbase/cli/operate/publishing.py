"""`rosbase topic pub`."""

from __future__ import annotations

import sys

from rosbase.cli.operate.reading import UsageError
from rosbase.cli.operate.values import as_call, encoded, parsed, read_values
from rosbase.control.names import full_type
from rosbase.control.questions.publishing import PublishQuestions
from rosbase.control.time_limit import TimeLimit, pause
from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.questions.publishing import Publication

__all__ = ["publish"]

_LOOK_S = 0.1
# A message that was late does not make all later ones so.
_MOST_BEHIND_S = 1.0


def publish(given: Any) -> None:
    """Publish messages in the program that subscribes, as `ros2 topic pub` prints it."""
    values = read_values(given.values)
    qos = _quality(given)
    questions = PublishQuestions(given.program)
    times = 1 if given.once else given.times
    wanted = given.wait_matching_subscriptions
    if wanted is None:
        wanted = 1 if given.once else 0
    if wanted:
        _check_early(questions, given.type, values)
        _wait_for(questions, given.topic, given.type, wanted)
    with questions.publisher(given.topic, given.type, qos=qos) as publication:
        _publish(publication, values, given, times)


def _quality(given: Any) -> dict[str, Any]:
    """Return the quality of service that the options ask for.

    Raises:
        UsageError: There is no such policy.
    """
    for flag, value, policies in (
        ("--qos-reliability", given.qos_reliability, ("reliable", "best_effort")),
        ("--qos-durability", given.qos_durability, ("volatile", "transient_local")),
    ):
        if value is not None and value.lower() not in policies:
            raise UsageError(f"{flag}: '{value}' is not one of {', '.join(policies)}")
    found = {
        "reliability": given.qos_reliability,
        "durability": given.qos_durability,
        "depth": given.qos_depth,
    }
    return {name: value for name, value in found.items() if value is not None}


def _check_early(questions: PublishQuestions, message_type: str, values: Any) -> None:
    """Tell of a mistake in the type or the values now, as far as the running programs know.

    Raises:
        UsageError: The values do not fit the type.
    """
    from rosbase.wire.plain import encoder

    reason: ControlError | None = None
    for process in questions.processes():
        try:
            found = questions.type_known_to(process["pid"], message_type)
        except ControlError as error:
            reason = error
            continue
        encoded(encoder(found["type"], found["schema"], lambda: 0), values)
        return
    if reason is not None:
        # One that starts later may know it.
        print(f"rosbase: {reason}", file=sys.stderr)


def _wait_for(questions: PublishQuestions, name: str, message_type: str, wanted: int) -> None:
    """Wait until so many subscriptions are there.

    Raises:
        ControlError: The topic is of another type.
    """
    looks = 0
    while True:
        try:
            topic = questions.topic(name)
            if full_type(message_type) not in topic["types"]:
                types = ", ".join(topic["types"])
                text = f"topic {topic['name']} is of type {types}, not {message_type}"
                raise ControlError(text, "invalid")
            found = len(topic["subscriptions"])
        except ControlError as error:
            if error.kind != "unknown" or error.suggestions:
                raise
            found = 0
        if found >= wanted:
            return
        if looks % 10 == 0:
            print(f"Waiting for at least {wanted} matching subscription(s)...", flush=True)
        looks += 1
        pause(_LOOK_S)


def _publish(publication: Publication, values: Any, given: Any, times: int | None) -> None:
    shape = parsed({"type": publication.type, "schema": publication.schema})
    count = 0
    period_s = 1.0 / given.rate
    limit = TimeLimit(0.0)
    while times is None or count < times:
        # A stamp of now differs from message to message.
        data = encoded(publication.encode, values)
        publication.publish_encoded(data)
        count += 1
        if count == 1:
            # Now that nothing has been refused.
            print("publisher: beginning loop")
        if given.print and count % given.print == 0:
            shown = as_call(shape, publication.decode(data))
            print(f"publishing #{count}: {shown}\n", flush=True)
        limit.restart(period_s, behind_s=_MOST_BEHIND_S)
        if times is None or count < times:
            pause(limit.left_s or 0.0)
