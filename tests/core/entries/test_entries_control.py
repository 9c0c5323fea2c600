"""Requests of the control socket to a recorded program."""

import threading
from collections.abc import Callable
from typing import Any

from rosbase import LifecycleNode, SetParametersResult
from rosbase.clock import SystemClock
from rosbase.contracts.message_format import message_format
from rosbase.control.programs import Program, RunningNode, may_be_offered, offered
from rosbase.entries.kinds import Kind
from rosbase.logger import RosbaseLogger
from rosbase.messages import Vector3
from rosbase.messages.std_srvs import SetBool
from support.conducted import ConductedProgram, Recorded, record, replay
from support.control import Asker, own_socket

SPEED = message_format(Vector3)


class Camera(LifecycleNode):
    """Notes what is asked of it."""

    program: ConductedProgram

    def on_configure(self, previous_state: Any) -> Any:
        self.program.see("configured", self.get_clock().now_ns())
        return super().on_configure(previous_state)


class Shown(Program):
    """The program, as clients see it."""

    phase = "running"

    def __init__(self, program: ConductedProgram, node: Camera) -> None:
        self.backend = program.backend
        self._node = node

    def nodes(self) -> list[RunningNode]:
        return [RunningNode("/robot", "", "Camera", self.backend, self._node)]


def asked(program: ConductedProgram, questions: Callable[[Asker], object]) -> None:
    """Runs a program while a client asks it."""
    backend = program.backend
    node = Camera(backend=backend)
    node.program = program
    node.declare_parameter("gain", 1.5)
    node.add_on_set_parameters_callback(lambda given: judge(program, given))
    backend.create_subscription(Vector3, "speed", lambda m: program.see("speed", m.x), 10)
    backend.create_service(SetBool, "switch", lambda r: answer(program, r))

    def ask() -> None:
        with Asker(own_socket()) as client:
            questions(client)

    assert may_be_offered(backend, wanted=True)
    with offered(Shown(program, node), RosbaseLogger("test")):
        program.spin_while(ask)


def judge(program: ConductedProgram, given: Any) -> SetParametersResult:
    program.see("asked", *(parameter.value for parameter in given))
    return SetParametersResult(successful=given[0].value != 13.0, reason="unlucky")


def answer(program: ConductedProgram, request: SetBool.Request) -> SetBool.Response:
    program.see("request", request.data)
    return SetBool.Response(success=True, message="yes")


def recorded_while(questions: Callable[[Asker], object]) -> Recorded:
    """Records a program that is asked; its replay must see the same."""
    recorded = record(lambda program: asked(program, questions), SystemClock())
    assert recorded.spoiled == []
    # That would be a thread of rosbase which hands over something that no replay has.
    assert Kind.POSTED not in recorded.kinds
    again = replay(lambda program: asked(program, questions), recorded)
    assert again == recorded.seen
    return recorded


def test_parameters_are_set_again() -> None:
    def questions(client: Asker) -> None:
        client.ask("parameter.set", node="/robot", values={"gain": 2})
        client.ask("parameter.set", node="/robot", values={"gain": {"text": "13.0"}})

    recorded = recorded_while(questions)
    assert recorded.seen == [("asked", 2.0), ("asked", 13.0)]
    assert recorded.kinds.count(Kind.CONTROL) == 2


def test_transitions_are_made_again() -> None:
    def questions(client: Asker) -> None:
        client.ask("lifecycle.set", node="/robot", transition="configure")
        assert "error" in client.answer("lifecycle.set", node="/robot", transition="configure")

    recorded = recorded_while(questions)
    assert [seen[0] for seen in recorded.seen] == ["configured"]
    assert recorded.kinds.count(Kind.CONTROL) == 2


def test_messages_of_a_client_come_again() -> None:
    def questions(client: Asker) -> None:
        for x in (1.0, 2.0, 3.0):
            client.ask("topic.publish", SPEED.encode(Vector3(x=x)), topic="/speed")

    recorded = recorded_while(questions)
    assert recorded.seen == [("speed", x) for x in (1.0, 2.0, 3.0)]
    # The first creates the publisher, and the end of the connection destroys it.
    assert recorded.kinds.count(Kind.CONTROL) == 2
    assert recorded.kinds.count(Kind.PUBLISH) == 2


def test_a_service_is_called_again() -> None:
    request = message_format(SetBool.Request).encode(SetBool.Request(True))

    def questions(client: Asker) -> None:
        client.ask("service.call", request, service="/switch", timeout_ns=2_000_000_000)

    recorded = recorded_while(questions)
    assert recorded.seen == [("request", True)]


def test_a_request_that_was_given_up_is_not_carried_out_in_a_replay() -> None:
    def questions(client: Asker) -> None:
        number = client.send("parameter.set", node="/robot", values={"gain": 2}, timeout_ns=1)
        frame, _ = client.read()
        assert frame["id"] == number
        assert "nothing was changed" in frame["error"]

        given_up.set()

    given_up = threading.Event()

    def run(program: ConductedProgram) -> None:
        # The thread of the socket answers while the program is busy.
        program.backend.call_soon(given_up.wait)
        asked(program, questions)

    recorded = record(run, SystemClock())
    assert recorded.seen == []
    assert recorded.kinds.count(Kind.CONTROL) == 1
    assert replay(run, recorded) == []
