"""Transitions of a recorded program, and what it publishes about itself."""

import threading
from typing import Any

from rosbase import CallbackReturn, LifecycleNode, SystemClock
from rosbase.contracts.backend import BackendOptions
from rosbase.entries.kinds import Kind
from rosbase.errors import TransitionNotAvailableError
from rosbase.local import LocalBackend
from rosbase.messages.lifecycle_msgs import TransitionEvent
from rosbase.messages.rcl_interfaces import ParameterEvent
from rosbase.messages.std_srvs import SetBool
from rosbase.testing import ManualClock
from support.conducted import ConductedProgram, record, replay


class Camera(LifecycleNode):
    """Notes its transitions."""

    program: ConductedProgram

    def on_configure(self, previous_state: Any) -> CallbackReturn:
        self.program.see("configured", self.get_clock().now_ns())
        return CallbackReturn.SUCCESS

    def on_error(self, previous_state: Any) -> CallbackReturn:
        self.program.see("error", str(self.last_error), self.get_clock().now_ns())
        return CallbackReturn.SUCCESS


def camera(program: ConductedProgram) -> Camera:
    node = Camera(backend=program.backend)
    node.program = program
    return node


def test_a_transition_of_another_thread_comes_again() -> None:
    answers: list[Any] = []

    def run(program: ConductedProgram) -> None:
        node = camera(program)
        program.spin_while(lambda: answers.append(node.trigger_configure()))
        program.see(node.get_state().label)

    recorded = record(run, SystemClock())
    assert answers == [CallbackReturn.SUCCESS]
    assert recorded.seen[1] == ("inactive",)
    assert recorded.kinds.count(Kind.CHANGE_STATE) == 1
    assert recorded.spoiled == []
    assert replay(run, recorded) == recorded.seen


def test_a_refused_transition_of_another_thread_is_refused_again() -> None:
    refusals: list[str] = []

    def run(program: ConductedProgram) -> None:
        node = camera(program)

        def activate() -> None:
            try:
                node.trigger_activate()
            except TransitionNotAvailableError as error:
                refusals.append(str(error))

        program.spin_while(activate)
        program.see(node.get_state().label)

    recorded = record(run, SystemClock())
    assert len(refusals) == 1
    assert recorded.seen == [("unconfigured",)]
    assert replay(run, recorded) == recorded.seen


def test_an_error_of_another_thread_comes_again() -> None:
    def run(program: ConductedProgram) -> None:
        node = camera(program)
        node.trigger_configure()
        program.spin_while(lambda: node.raise_error(ValueError("too hot")))

    recorded = record(run, SystemClock())
    assert recorded.seen[1][:2] == ("error", "too hot")
    assert replay(run, recorded) == recorded.seen


def test_events_are_published_again_although_nobody_else_listens() -> None:
    def run(program: ConductedProgram) -> None:
        if not program.conductor.is_replay:
            # It does not belong to the program.
            other = LocalBackend(BackendOptions("other", clock=ManualClock()), program.bus)
            other.create_subscription(ParameterEvent, "/parameter_events", print, 10)
            other.create_subscription(TransitionEvent, "/robot/transition_event", print, 10)
        node = camera(program)
        node.declare_parameter("gain", 1.0)
        # It reads the clock for its stamps, and so must not come out of step.
        node.set_parameter("gain", 2.0)
        program.see(node.get_clock().now_ns())
        node.trigger_configure()
        program.spin()

    recorded = record(run)
    assert replay(run, recorded) == recorded.seen


def test_the_end_waits_for_a_transition_that_waits_for_the_turn() -> None:
    def run(program: ConductedProgram) -> None:
        node = camera(program)
        program.backend.create_service(SetBool, "switch", lambda _: SetBool.Response())
        client = program.backend.create_client(SetBool, "switch")
        called = threading.Event()

        def call(_: Any) -> CallbackReturn:
            called.set()
            client.call(SetBool.Request(), 0.2)
            return CallbackReturn.SUCCESS

        vars(node)["on_configure"] = call
        thread = threading.Thread(target=node.trigger_configure, name="outside")
        thread.start()
        program.spin(0.05)
        assert called.is_set()
        program.see(node._transitions.wait_for_others(5.0))
        program.conductor.aside(thread.join)
        program.see(node.get_state().label)

    recorded = record(run, SystemClock())
    assert recorded.seen[0] == (True,)
    assert recorded.spoiled == ["a thread other than the main loop's waited within an entry"]
