"""Arguments of wrong kinds: no client can raise an exception in a program that it looks at."""

import json
import logging
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rosbase import BaseHandlers, BaseManager, LifecycleNode
from rosbase.control.answers import all_answers
from rosbase.messages import String
from rosbase.messages.std_srvs import SetBool
from support.control import Asker, ask_while_running, own_socket
from support.strategies import json_values

# An exception of an answer is told as this kind, and so is a refusal of a type without a schema.
KINDS = {"unknown", "invalid", "refused", "timeout", "ambiguous", "failed"}
# They end the program, and take no argument that this one has not.
HARMLESS = sorted(set(all_answers()) - {"stop"})
RIGHT: dict[str, list[Any]] = {
    "node": ["camera", "/app"],
    "name": ["camera"],
    "names": [["fps"]],
    "values": [{"fps": 31}],
    "topic": ["/words"],
    "type": ["std_msgs/msg/String", "std_srvs/srv/SetBool"],
    "service": ["/switch"],
    "transition": ["deactivate", 3],
    "level": ["INFO", 20],
    "program": ["/app"],
    "qos": [{"depth": 1}, {"reliability": "reliable"}],
}
WRONG = ("limit", "every_ns", "with", "atomically", "timeout_ns", "last", "follow", "of")
NAMES = st.sampled_from([*RIGHT, *WRONG])
QOS = st.dictionaries(
    st.sampled_from(["depth", "reliability", "durability", "history"]), json_values, min_size=1
)
VALUES = st.dictionaries(
    st.sampled_from(["fps", "label", "gains", "x"]), json_values, min_size=1, max_size=3
)
HUGE = st.sampled_from([2**31, 2**53, 2**63, 10**30, -1, 0])
ASKS = st.sampled_from([*HARMLESS, "cancel", "parameter.set", "topic.publish"])


class Camera(LifecycleNode):
    autostart = "activate"

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.declare_parameter("fps", 30)
        self.declare_parameter("label", "a")
        self.declare_parameter("gains", [1.0])
        self.create_publisher(String, "/words", 1)
        self.create_service(SetBool, "/switch", lambda _: SetBool.Response())


class Handlers(BaseHandlers):
    def handle(self) -> None:
        pass


@st.composite
def arguments(draw: Any) -> dict[str, Any]:
    """Right ones, of which some are replaced."""
    chosen = {name: draw(st.sampled_from(right)) for name, right in RIGHT.items()}
    chosen["timeout_ns"] = 1_000_000
    kept: dict[str, Any] = {
        name: value for name, value in chosen.items() if draw(st.integers(0, 3))
    }
    for name in draw(st.lists(NAMES, max_size=3)):
        special = {"qos": QOS, "values": VALUES}.get(name, HUGE)
        kept[name] = draw(json_values | special)
    return kept


def test_no_arguments_raise_an_exception_in_the_program(
    caplog: pytest.LogCaptureFixture,
) -> None:
    caplog.set_level(logging.ERROR)

    @settings(max_examples=400, deadline=None, suppress_health_check=list(HealthCheck))
    @given(ask=ASKS, given_arguments=arguments())
    def check(ask: str, given_arguments: dict[str, Any]) -> None:
        caplog.clear()
        with Asker(own_socket()) as client:
            line = json.dumps({**given_arguments, "id": 1, "ask": ask})
            client.socket.sendall(line.encode() + b"\n")
            frame = client.read()[0]
            # Numbers that are none, and those that are too long, are no JSON.
            assert frame["id"] == 1 or frame["kind"] == "invalid"
            assert "ok" in frame or frame["kind"] in KINDS, frame
            for name in ("TypeError", "KeyError", "ValueError", "OverflowError", "AttributeError"):
                assert not frame.get("error", "").startswith(name), frame
            # A stream goes on, and the thread with it.
            if frame["id"] == 1:
                client.send("process")
        with Asker(own_socket()) as other:
            assert other.ask("process")
        assert [record.getMessage() for record in caplog.records] == []

    def questions(_: Asker) -> None:
        check()

    app = BaseManager("app", {"camera": Camera}, {}, Handlers, node_freq_hz=200)
    ask_while_running(app, questions)


@pytest.mark.parametrize("value", [{}, [], "1", None, 1.0, True])
def test_a_cancellation_of_a_number_that_is_none_is_an_error(value: Any) -> None:
    def questions(client: Asker) -> None:
        answer = client.answer("cancel", of=value)
        assert answer["kind"] == "invalid", answer
        assert "of" in answer["error"]

    ask_while_running(BaseManager("app", {}, {}, Handlers, node_freq_hz=100), questions)
