"""`rosbase topic pub`."""

from __future__ import annotations

from rosbase.cli.operate.values import as_call, encoded, parsed, read_values
from rosbase.control.questions.publishing import PublishQuestions
from rosbase.control.time_limit import TimeLimit, pause

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rosbase.control.questions.publishing import Publication

__all__ = ["publish"]

_LOOK_S = 0.1


def publish(given: Any) -> None:
    """Publish messages in the program that subscribes, as `ros2 topic pub` prints it."""
    values = read_values(given.values)
    qos = {
        name: value
        for name, value in (
            ("reliability", given.qos_reliability),
            ("durability", given.qos_durability),
            ("depth", given.qos_depth),
        )
        if value is not None
    }
    questions = PublishQuestions(given.program)
    times = 1 if given.once else given.times
    wanted = given.wait_matching_subscriptions
    if wanted is None:
        wanted = 1 if given.once else 0
    if wanted:
        _wait_for(questions, given.topic, wanted)
    with questions.publisher(given.topic, given.type, qos=qos) as publication:
        _publish(publication, values, given, times)


def _wait_for(questions: PublishQuestions, name: str, wanted: int) -> None:
    """Wait until so many subscriptions are there."""
    from rosbase.errors import ControlError

    looks = 0
    while True:
        try:
            found = len(questions.topic(name)["subscriptions"])
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
    print("publisher: beginning loop")
    count = 0
    period_s = 1.0 / given.rate
    limit = TimeLimit(0.0)
    while times is None or count < times:
        # A stamp of now differs from message to message.
        data = encoded(publication.encode, values)
        publication.publish_encoded(data)
        count += 1
        if given.print and count % given.print == 0:
            shown = as_call(shape, publication.decode(data))
            print(f"publishing #{count}: {shown}\n", flush=True)
        limit.restart(period_s)
        if times is None or count < times:
            pause(limit.left_s or 0.0)
