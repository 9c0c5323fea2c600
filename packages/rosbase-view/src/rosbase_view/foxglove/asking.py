"""Ask the programs for the type of a topic."""

from rosbase import ControlError
from rosbase.control.gathering import ask_one
from rosbase.control.shapes import Topic
from rosbase_view.reports import TopicKey

__all__ = ["schema_of"]

_ANSWER_S = 1.0


def schema_of(_: TopicKey, topic: Topic) -> tuple[str, str]:
    """Return the type of the messages of a topic, and its schema.

    Raises:
        ControlError: Its programs have ended or do not answer, or its messages have no schema.
    """
    # Not each process knows the class.
    pids = dict.fromkeys(end["pid"] for end in (*topic["publishers"], *topic["subscriptions"]))
    failure = ControlError(f"the program of topic {topic['name']} has ended", "unknown")
    for pid in pids:
        try:
            found = ask_one(pid, "topic.type", {"topic": topic["name"]}, wait_s=_ANSWER_S)[0]
        except ControlError as error:
            failure = error
        else:
            return found["type"], found["schema"]
    # The errors of a connection are of this kind too.
    is_final = failure.kind == "failed" and "has no schema" in str(failure)
    raise ControlError(str(failure), "failed" if is_final else "unknown")
