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
            other.create_subscription(ParameterEvent, "/parameter_events", list, 10)
            other.create_subscription(TransitionEvent, "/robot/transition_event", list, 10)
        node = camera(program)
        node.declare_parameter("gain", 1.0)
        # It reads the clock for its stamps, and so must not come out of step.
        node.set_parameter("gain", 2.0)
        program.see(node.get_clock().now_ns())
        node.trigger_configure()
        program.spin()

    recorded = record(run)
    assert replay(run, recorded) == recorded.seen


def test_the_end_waits_for_the_transition_of_a_thread_that_needs_the_turn() -> None:
    def run(program: ConductedProgram) -> None:
        node = camera(program)
        begun = threading.Event()

        def configure() -> None:
            begun.set()
            node.trigger_configure()

        thread = threading.Thread(target=configure, name="outside")
        if not program.conductor.is_replay:
            thread.start()
            begun.wait()
        # Inside, until `aside` lets go of the turn.
        program.see(node._transitions.wait_for_others(5.0))
        if not program.conductor.is_replay:
            program.conductor.aside(thread.join)
        program.spin()
        program.see(node.get_state().label)

    recorded = record(run)
    assert recorded.seen[-1] == ("inactive",)
    assert recorded.spoiled == []
