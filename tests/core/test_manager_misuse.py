"""Managers used in ways that they are not made for: a clear error, and nothing left behind."""

import threading
from typing import Any

import pytest

from rosbase import BaseHandlers, BaseManager, CallbackReturn, LifecycleNode, State
from rosbase.errors import HandshakeTimeoutError
from rosbase.testing import ManualClock, virtual_backend
from support.roles import StopAfter
from support.waiting import wait_until


@pytest.mark.parametrize(
    "rate", [0, -1, None, "200", [1], 1j, 10**400, float("nan"), float("inf")], ids=repr
)
def test_a_rate_that_is_none_is_a_value_error(rate: Any) -> None:
    with pytest.raises(ValueError, match="positive number of hertz"):
        BaseManager(node_freq_hz=rate, backend=virtual_backend())


@pytest.mark.parametrize("timeout", ["5", -1.0, float("nan")], ids=repr)
def test_a_handshake_timeout_that_is_none_is_a_value_error(timeout: Any) -> None:
    with pytest.raises(ValueError, match="a number of seconds"):
        BaseManager(handshake_timeout=timeout, backend=virtual_backend())


def test_a_rule_that_cannot_be_called_is_refused() -> None:
    manager = BaseManager(backend=virtual_backend())
    with pytest.raises(TypeError, match="handshake rule 'x' takes a function, not True"):
        manager.add_handshake_rule("x", True)  # type: ignore[arg-type]  # the mistake is the test
    manager.destroy_node()


def test_each_rule_is_asked_once_in_each_round_and_a_moment_is_not_missed() -> None:
    answers = iter([False, False, False, True])
    manager = BaseManager(
        handlers_class=StopAfter, handshake_timeout=3.0, backend=virtual_backend()
    )
    manager.add_handshake_rule("edge", lambda: next(answers, False))
    manager.start_main_loop_timer()
    assert manager.timestamp == 5


def test_rules_of_one_name_are_reported_each(caplog: pytest.LogCaptureFixture) -> None:
    manager = BaseManager(handshake_timeout=1.0, backend=virtual_backend())
    for text in ("one", "two"):
        manager.add_handshake_rule("same", lambda t=text: {}[t])  # type: ignore[misc]  # mypy infers no default of a lambda
    with pytest.raises(HandshakeTimeoutError, match="same, same"):
        manager.start_main_loop_timer()
    reports = [m for m in caplog.messages if m.startswith("handshake rule 'same' raised")]
    assert len(reports) == 2


def test_a_manager_cannot_be_started_from_within_its_own_loop() -> None:
    class Again(BaseHandlers):
        manager: BaseManager

        def handle(self) -> None:
            self.manager.start_main_loop_timer()

    released: list[int] = []

    class App(BaseManager):
        def release_resources(self) -> None:
            released.append(self.timestamp)

    with pytest.raises(RuntimeError, match="a manager runs once"):
        App(handlers_class=Again, backend=virtual_backend()).start_main_loop_timer()
    assert released == [0]


def test_children_that_are_none_end_in_the_whole_clean_up() -> None:
    backend = virtual_backend()
    with pytest.raises(TypeError, match="is not a return value of register_multiprocess_nodes"):
        BaseManager(backend=backend).start_main_loop_timer(["sleep 1"])  # type: ignore[arg-type]  # the mistake is the test
    assert backend._closed


def test_an_autostart_that_is_none_is_named() -> None:
    class Device(LifecycleNode):
        autostart = "active"  # type: ignore[assignment]  # the mistake is the test

    manager = BaseManager(nodes_dict={"d": Device}, backend=virtual_backend())
    with pytest.raises(ValueError, match="autostart of Device is one of none, configure, activate"):
        manager.start_main_loop_timer()


def test_a_state_handle_with_options_only_is_called_without_the_switch() -> None:
    called: list[dict[str, Any]] = []

    class App(BaseManager):
        def state_handle(self, **options: Any) -> None:
            called.append(options)

    App(handlers_class=StopAfter, backend=virtual_backend()).start_main_loop_timer()
    assert called == [{}] * 5


def test_a_stop_during_a_transition_on_another_thread_waits_for_it_and_takes_the_node_down() -> (
    None
):
    opening, opened, trace = threading.Event(), threading.Event(), []

    class Device(LifecycleNode):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            opening.set()
            opened.wait(10)
            trace.append("opened")
            return CallbackReturn.SUCCESS

        def on_cleanup(self, previous_state: State) -> CallbackReturn:
            trace.append("given back")
            return CallbackReturn.SUCCESS

    class Stop(BaseHandlers):
        def handle(self) -> None:
            self.manager.request_stop()

    class App(BaseManager):
        def release_resources(self) -> None:
            trace.append("released")

    app = App(nodes_dict={"d": Device}, handlers_class=Stop)
    device = app.nodes["d"]
    thread = threading.Thread(target=device.trigger_configure)
    thread.start()
    opening.wait(10)

    def open_at_last() -> None:
        wait_until(lambda: app.timestamp == 1, "the last tick")
        opened.set()

    opener = threading.Thread(target=open_at_last)
    opener.start()
    app.start_main_loop_timer()
    thread.join()
    opener.join()
    assert trace == ["opened", "given back", "released"]
    assert device.get_state() is State.FINALIZED


def test_virtual_time_that_stands_still_is_an_error_and_no_hang(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("rosbase.testing.clock._FOR_EVER", 10_000)
    backend = virtual_backend(ManualClock())

    def again() -> None:
        backend.call_soon(again)

    again()
    with pytest.raises(RuntimeError, match="virtual time stands still"):
        BaseManager(backend=backend).start_main_loop_timer()
