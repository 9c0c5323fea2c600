"""What programs say and do when a client asks."""

import logging
import os
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BaseHandlers,
    BaseManager,
    BaseNode,
    CallbackReturn,
    ConfigurationError,
    LifecycleNode,
    ParameterKind,
    ParameterSpec,
    SetParametersResult,
    State,
)
from rosbase.control import programs
from rosbase.control.recent_log import recent_log
from rosbase.manager.main_loop import run_main_loop
from rosbase.testing import virtual_backend
from support.control import Asker, ask_while_running, own_socket
from support.waiting import wait_until


class Camera(LifecycleNode):
    autostart = "activate"
    answer = CallbackReturn.SUCCESS

    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.declare_parameter("fps", 30, ParameterSpec("", 0, "frames", minimum=1, maximum=60))
        self.declare_parameter("device", "a", ParameterSpec("", "", change_time="unconfigured"))
        self.declare_parameter("serial", "B2", ParameterSpec("", "", read_only=True))

    def on_deactivate(self, previous_state: State) -> CallbackReturn:
        self.last_error = None if self.answer is CallbackReturn.SUCCESS else ValueError("stuck")
        return self.answer


class Robot(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        for name, value in {
            "gain": 1.5,
            "name": "on",
            "flags": [True, False],
            "octets": [b"a", b"\xff"],
        }.items():
            self.declare_parameter(name, value)  # type: ignore[type-var]  # each is one
        self.declare_parameter("none", [], ParameterSpec("", [], kind=ParameterKind.DOUBLE_ARRAY))
        self.add_on_set_parameters_callback(self.judge)
        self.judged_on: set[int] = set()

    def judge(self, parameters: list[Any]) -> SetParametersResult:
        self.judged_on.add(threading.get_ident())
        is_fine = all(parameter.value != 13.0 for parameter in parameters)
        return SetParametersResult(is_fine, "" if is_fine else "unlucky")


NODES = {"camera": Camera, "robot": Robot}


class Handlers(BaseHandlers):
    def handle(self) -> None:
        pass


def app(**options: Any) -> BaseManager:
    options = {"nodes_dict": NODES, "handlers_class": Handlers, "node_freq_hz": 100, **options}
    return BaseManager("app", **options)


def ask(questions: Callable[[Asker], None], **options: Any) -> BaseManager:
    manager = app(**options)
    ask_while_running(manager, questions)
    return manager


# The process.


def test_a_process_tells_what_runs_in_it_and_what_it_uses() -> None:
    def questions(client: Asker) -> None:
        wait_until(lambda: client.ask("process")["programs"][0]["ticks"] > 3, "some ticks")
        found = client.ask("process")
        assert found["pid"] == os.getpid()
        assert found["command"][0].endswith("python") or "python" in found["command"][0]
        assert found["name"] == "/app"
        assert 5_000_000 < found["memory_bytes"] < 10**10
        assert found["threads"] >= 3
        assert 0 < found["cpu_ns"] < 10**13
        now_ns = programs.running_programs()[0].backend.clock.now_ns()  # type: ignore[union-attr]  # it has one
        assert now_ns - 10**12 < found["started_ns"] < now_ns
        (program,) = found["programs"]
        assert 0 < program.pop("up_ns") < 10**11
        assert program.pop("ticks") > 3
        assert program.pop("overruns") >= 0
        # One may just run.
        assert (program.pop("tick_ns") or 0) < 10**10
        assert program == {
            "name": "/app",
            "kind": "manager",
            "class": "BaseManager",
            "backend": "local",
            "network": "",
            "phase": "running",
            "waiting_for": [],
            "state": "searching",
            "rate_hz": 100.0,
            "nodes": ["/app", "/camera"],
            "children": [],
        }

    ask(questions, start_state="searching")


def test_a_handshake_is_told_with_what_it_waits_for() -> None:
    manager, is_there = app(), threading.Event()
    manager.add_handshake_rule("the camera's first image", is_there.is_set)
    manager.add_handshake_rule("nothing", lambda: True)

    def questions(client: Asker) -> None:
        wait_until(lambda: told(client)["waiting_for"] == ["the camera's first image"], "the rule")
        # The loop is not yet there, and requests are carried out all the same.
        assert client.ask("parameter.set", node="camera", values={"fps": 20})["results"]["fps"]
        assert client.ask("lifecycle.get", node="camera")["state"] == "unconfigured"
        is_there.set()
        wait_until(lambda: told(client)["phase"] == "running", "the loop")
        assert told(client)["waiting_for"] == []
        assert client.ask("lifecycle.get", node="camera")["state"] == "active"

    ask_while_running(manager, questions, until="handshake")


def told(client: Asker) -> dict[str, Any]:
    return dict(client.ask("process")["programs"][0])


def test_a_lone_node_is_a_program_too() -> None:
    node = Camera(node_name="eye")

    def questions(client: Asker) -> None:
        program = told(client)
        assert (program["kind"], program["name"], program["class"]) == ("node", "/eye", "Camera")
        assert (program["rate_hz"], program["ticks"]) == (None, 0)
        listed = client.ask("node.list")["nodes"]
        assert [(one["name"], one["key"], one["lifecycle"]) for one in listed] == [
            ("/eye", "", "active")
        ]
        assert client.ask("lifecycle.set", node="eye", transition="deactivate")["successful"]
        assert client.ask("statistics")["programs"][0]["period"] is None
        assert client.ask("stop") == {"programs": ["/eye"]}

    ask_while_running(node, questions)
    assert node.get_state() is State.FINALIZED


def test_two_programs_share_the_socket_and_each_may_be_stopped() -> None:
    first, second = app(), BaseNode(node_name="other")
    thread = threading.Thread(target=second.start_spin_standalone)

    def questions(client: Asker) -> None:
        thread.start()
        wait_until(lambda: len(client.ask("process")["programs"]) == 2, "the other")
        assert client.ask("process")["name"] == "/app"
        assert client.ask("stop", program="other") == {"programs": ["/other"]}
        thread.join()
        assert len(client.ask("process")["programs"]) == 1
        answer = client.answer("stop", program="/othr")
        assert answer["kind"] == "unknown"
        assert client.ask("stop") == {"programs": ["/app"]}

    ask_while_running(first, questions)


# On and off.


def test_the_socket_is_there_from_the_handshake_until_after_the_clean_up() -> None:
    seen: dict[str, bool] = {}

    class App(BaseManager):
        def handshake(self) -> bool:
            seen["handshake"] = os.path.exists(own_socket())
            return True

        def destroy_node(self) -> None:
            with Asker(own_socket()) as client:
                seen["end"] = told(client)["phase"] == "stopping"
                answer = client.answer("parameter.set", node="app", values={})
                seen["refused"] = answer["kind"] == "refused"
            super().destroy_node()

    class Once(BaseHandlers):
        def handle(self) -> None:
            self.manager.request_stop()

    manager = App("app", handlers_class=Once)
    assert not os.path.exists(own_socket())
    manager.start_main_loop_timer()
    assert seen == {"handshake": True, "end": True, "refused": True}
    assert not os.path.exists(own_socket())


class Looking(BaseHandlers):
    """Notes whether there is a socket, and ends."""

    def handle(self) -> None:
        self.manager.state = str(os.path.exists(own_socket()))
        self.manager.request_stop()


@pytest.mark.parametrize(
    ("word", "there"), [("off", False), ("0", False), ("FALSE", False), ("on", True), ("", True)]
)
def test_the_environment_turns_it_off(
    monkeypatch: pytest.MonkeyPatch, word: str, there: bool
) -> None:
    monkeypatch.setenv("ROSBASE_CONTROL", word)
    manager = BaseManager("app", handlers_class=Looking)
    manager.start_main_loop_timer()
    assert manager.state == str(there)


def test_a_word_that_is_neither_on_nor_off_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROSBASE_CONTROL", "maybe")
    with pytest.raises(ConfigurationError, match="ROSBASE_CONTROL is on or off, not 'maybe'"):
        BaseManager("app")
    with pytest.raises(ConfigurationError, match="ROSBASE_CONTROL"):
        BaseNode()


def test_a_program_may_turn_it_off() -> None:
    manager = BaseManager("app", handlers_class=Looking, control=False)
    manager.start_main_loop_timer()
    assert manager.state == "False"
    node = BaseNode(control=False)
    found: list[bool] = []

    def look() -> None:
        found.append(os.path.exists(own_socket()))
        node.request_stop()

    node.create_timer(0.001, look)
    node.start_spin_standalone()
    assert found[0] is False


def test_a_control_that_is_no_switch_is_an_error() -> None:
    with pytest.raises(TypeError, match="control is True or False, not 'steering'"):
        BaseManager("app", control="steering")  # type: ignore[arg-type]  # the mistake
    with pytest.raises(TypeError, match="control is True or False"):
        BaseNode(control=1)  # type: ignore[arg-type]  # the mistake


def test_in_virtual_time_there_is_none() -> None:
    manager = BaseManager("app", handlers_class=Looking, backend=virtual_backend())
    manager.start_main_loop_timer()
    assert manager.state == "False"


def test_a_run_that_fails_takes_the_socket_along() -> None:
    class Failing(BaseHandlers):
        def handle(self) -> None:
            raise ValueError("lens cap")

    with pytest.raises(ValueError, match="lens cap"):
        BaseManager("app", handlers_class=Failing).start_main_loop_timer()
    assert not os.path.exists(own_socket())
    assert programs.running_programs() == ()


# Nodes.


def test_nodes_are_listed_with_their_keys_and_states() -> None:
    def questions(client: Asker) -> None:
        listed = client.ask("node.list")["nodes"]
        assert [tuple(one.values()) for one in listed] == [
            ("/app", "/app", "BaseManager", "", None),
            ("/camera", "/app", "Camera", "camera", "active"),
            ("/app", "/app", "Robot", "robot", None),
        ]
        assert client.ask("node.info", name="camera")["parameters"] == 3
        assert client.ask("node.info", name="/app")["parameters"] == 5
        assert client.ask("node.info", name="robot")["parameters"] == 5
        answer = client.answer("node.info", name="camra")
        assert (answer["kind"], answer["suggestions"]) == ("unknown", ["camera", "/camera"])
        assert client.answer("node.info")["kind"] == "invalid"

    ask(questions)


def test_a_lifecycle_node_of_the_managers_name_is_its_own_node() -> None:
    def questions(client: Asker) -> None:
        (node,) = client.ask("node.list")["nodes"]
        assert (node["name"], node["key"], node["class"]) == ("/app", "app", "Camera")
        assert client.ask("lifecycle.get", node="app")["state"] == "active"
        assert client.ask("parameter.list") == {"nodes": {"/app": ["fps", "device", "serial"]}}

    ask(questions, nodes_dict={"app": Camera})


def test_a_component_without_a_connection_is_listed() -> None:
    class Bare(BaseNode):
        def __init__(self, manager: Any = None) -> None:
            pass

    def questions(client: Asker) -> None:
        assert client.ask("node.list")["nodes"][1]["class"] == "Bare"
        assert client.ask("node.info", name="bare")["parameters"] == 0
        assert client.answer("parameter.get", node="bare")["kind"] == "refused"
        assert client.ask("parameter.list") == {"nodes": {"/app": []}}

    ask(questions, nodes_dict={"bare": Bare})


# Parameters.


def test_parameters_are_listed_read_and_described() -> None:
    def questions(client: Asker) -> None:
        robots = ["robot.gain", "robot.name", "robot.flags", "robot.octets", "robot.none"]
        cameras = ["fps", "device", "serial"]
        assert client.ask("parameter.list") == {"nodes": {"/app": robots, "/camera": cameras}}
        assert client.ask("parameter.list", node="/camera") == {"nodes": {"/camera": cameras}}
        assert client.ask("parameter.get", node="robot") == {
            "node": "/app",
            "values": {
                "gain": {"type": "double", "value": 1.5},
                "name": {"type": "string", "value": "on"},
                "flags": {"type": "bool_array", "value": [True, False]},
                "octets": {"type": "byte_array", "value": [97, 255]},
                "none": {"type": "double_array", "value": []},
            },
        }
        one = client.ask("parameter.get", node="app", names=["robot.gain"])
        assert one["values"] == {"robot.gain": {"type": "double", "value": 1.5}}
        described = client.ask("parameter.describe", node="camera")["descriptors"]
        assert described["fps"] == {
            "type": "integer",
            "description": "frames",
            "constraints": "",
            "read_only": False,
            "range": [1, 60],
            "change_time": "always",
            "default": 30,
        }
        assert described["device"]["change_time"] == "unconfigured"
        assert described["device"]["constraints"] == "set it while unconfigured"
        assert described["serial"]["read_only"] is True
        for request in ("parameter.get", "parameter.describe"):
            answer = client.answer(request, node="camera", names=["fpps"])
            assert (answer["kind"], answer["suggestions"]) == ("unknown", ["fps"])
        assert client.answer("parameter.get", node="camera", names="fps")["kind"] == "invalid"

    ask(questions)


def test_parameters_are_set_on_the_main_loop_and_refused_with_reasons() -> None:
    def results(client: Asker, node: str, **given: Any) -> list[tuple[bool, str]]:
        found = client.ask("parameter.set", node=node, **given)["results"]
        return [(one["successful"], one["reason"]) for one in found.values()]

    def questions(client: Asker) -> None:
        assert results(client, "robot", values={"gain": 2, "octets": [1, 2]}) == [(True, "")] * 2
        assert results(client, "robot", values={"name": {"text": "off"}}) == [(True, "")]
        assert results(client, "robot", values={"flags": {"text": "[off, on]"}}) == [(True, "")]
        values = client.ask("parameter.get", node="robot")["values"]
        assert [one["value"] for one in values.values()] == [2.0, "off", [False, True], [1, 2], []]
        assert results(client, "robot", values={"gain": 13, "name": "x"}) == [
            (False, "unlucky"),
            (True, ""),
        ]
        together = results(client, "robot", values={"gain": 13, "name": "y"}, atomically=True)
        assert together == [(False, "unlucky")] * 2
        values = client.ask("parameter.get", node="robot", names=["gain", "name"])["values"]
        assert [one["value"] for one in values.values()] == [2.0, "x"]
        assert results(client, "camera", values={"fps": 61, "serial": "C3", "fpps": 1}) == [
            (False, "parameter fps is at most 60, not 61"),
            (False, "parameter camera.serial is read-only"),
            (False, "parameter 'fpps' has not been declared"),
        ]
        assert "takes a whole number" in results(client, "camera", values={"fps": "many"})[0][1]
        assert "has a text" in results(client, "camera", values={"fps": {"x": 1}})[0][1]
        (device,) = results(client, "camera", values={"device": "b"})
        assert not device[0]
        assert client.answer("parameter.set", node="camera")["kind"] == "invalid"
        assert client.answer("parameter.set", node="camera", values=[1])["kind"] == "invalid"

    manager = ask(questions)
    assert manager.node(Robot).judged_on == {threading.get_ident()}


# The lifecycle.


@pytest.mark.parametrize("value", ["a\ud800", {"text": "a\udcff"}])
@pytest.mark.parametrize("together", [True, False])
def test_a_text_with_half_a_surrogate_is_refused(value: Any, together: bool) -> None:
    def questions(client: Asker) -> None:
        values = {"name": value}
        found = client.ask("parameter.set", node="words", values=values, atomically=together)
        result = found["results"]["name"]
        assert not result["successful"]
        assert "has half a surrogate" in result["reason"]
        values = {"names": ["b", "\ud800"]}
        found = client.ask("parameter.set", node="words", values=values, atomically=together)
        assert not found["results"]["names"]["successful"]
        kept = client.ask("parameter.get", node="words")["values"]
        assert (kept["name"]["value"], kept["names"]["value"]) == ("on", ["a"])

    class Words(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.declare_parameter("name", "on")
            self.declare_parameter("names", ["a"])

    ask(questions, nodes_dict={"words": Words})


def test_transitions_are_made_on_request_and_refused_with_the_reason() -> None:
    def change(client: Asker, transition: Any) -> tuple[Any, ...]:
        answer = client.answer("lifecycle.set", node="camera", transition=transition)
        if "error" in answer:
            return answer["kind"], answer["error"]
        ok = answer["ok"]
        return ok["successful"], ok["result"], ok["state"], ok["reason"]

    def questions(client: Asker) -> None:
        assert client.ask("lifecycle.list") == {
            "nodes": [{"name": "/camera", "state": "active", "id": 3}]
        }
        assert [
            one["label"] for one in client.ask("lifecycle.get", node="camera")["available"]
        ] == [
            "deactivate",
            "shutdown",
        ]
        assert change(client, "configure") == (
            "refused",
            "no transition 'configure' is available in state active",
        )
        assert change(client, "deactivate") == (True, "success", "inactive", "")
        assert change(client, "2") == (True, "success", "unconfigured", "")
        assert change(client, 1) == (True, "success", "inactive", "")
        assert change(client, "activate") == (True, "success", "active", "")
        Camera.answer = CallbackReturn.FAILURE
        assert change(client, "deactivate") == (False, "failure", "active", "stuck")
        Camera.answer = CallbackReturn.ERROR
        assert change(client, 4)[:3] == (False, "error", "unconfigured")
        wrongs: list[Any] = [None, "", 1.5, []]
        for wrong in wrongs:
            assert change(client, wrong)[0] == "invalid"
        answer = client.answer("lifecycle.get", node="robot")
        assert (answer["kind"], answer["suggestions"]) == ("refused", ["/camera"])

    try:
        ask(questions)
    finally:
        Camera.answer = CallbackReturn.SUCCESS


# While the loop blocks.


class Blocking(BaseHandlers):
    """Blocks in its first tick until the test is done."""

    def __init__(self, manager: Any, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.is_blocked, self.may_go_on = threading.Event(), threading.Event()

    def handle(self) -> None:
        self.is_blocked.set()
        assert self.may_go_on.wait(20)


def test_while_the_loop_blocks_all_is_read_and_changes_time_out_and_are_never_made() -> None:
    manager = app(handlers_class=Blocking)
    handlers: Any = manager.handlers

    def questions(client: Asker) -> None:
        assert handlers.is_blocked.wait(20)
        asks = ("process", "node.list", "parameter.list", "lifecycle.list", "statistics", "log")
        for name in asks:
            assert client.ask(name)
            if name == "log":
                client.read()
        assert client.ask("parameter.get", node="camera")["values"]["fps"]["value"] == 30
        answer = client.answer(
            "parameter.set", node="camera", values={"fps": 20}, timeout_ns=50_000_000
        )
        assert answer["kind"] == "timeout"
        assert answer["error"] == "the main loop of /app is busy: nothing was changed"
        number = client.send("parameter.set", node="camera", values={"fps": 25})
        handlers.may_go_on.set()
        assert client.read()[0]["id"] == number
        assert client.ask("parameter.get", node="camera")["values"]["fps"]["value"] == 25
        # The callback runs after the answer, and not at all if the program stops first.
        wait_until(lambda: changes, "the callback's call")

    changes: list[int] = []
    camera = manager.node(Camera)
    camera.add_post_set_parameters_callback(lambda given: changes.extend(p.value for p in given))
    ask_while_running(manager, questions)
    assert changes == [25]


@pytest.mark.parametrize("timing", ["normal", "precise"])
def test_a_tick_that_hangs_is_told_with_its_age(timing: str) -> None:
    manager = app(handlers_class=Blocking, timing=timing)
    handlers: Any = manager.handlers

    def questions(client: Asker) -> None:
        assert handlers.is_blocked.wait(20)
        ages = [told(client)["tick_ns"] for _ in range(2)]
        ages.append(client.ask("statistics")["programs"][0]["tick_ns"])
        assert 0 < ages[0] < ages[1] < ages[2] < 20 * 10**9
        handlers.may_go_on.set()
        wait_until(lambda: told(client)["tick_ns"] is None, "the end of the tick")

    ask_while_running(manager, questions)
    assert manager.loop_stats.tick_started_ns is None
    assert manager.loop_stats.busy.count == manager.loop_stats.ticks


def test_a_tick_that_has_failed_no_longer_runs() -> None:
    class Failing(BaseHandlers):
        def handle(self) -> None:
            raise KeyError("lens")

    manager = app(handlers_class=Failing)
    with pytest.raises(KeyError):
        manager.start_main_loop_timer()
    assert manager.loop_stats.tick_started_ns is None
    assert manager.loop_stats.ticks == 0


def test_a_change_that_has_begun_says_so_when_its_time_is_up() -> None:
    may_end = threading.Event()
    manager = app()
    robot = manager.node(Robot)
    robot.add_on_set_parameters_callback(lambda _: SetParametersResult(may_end.wait(20)))

    def questions(client: Asker) -> None:
        answer = client.answer(
            "parameter.set", node="robot", values={"gain": 3}, timeout_ns=200_000_000
        )
        assert answer["error"] == "the main loop of /app has begun with it, and is not done"
        may_end.set()

    ask_while_running(manager, questions)
    assert robot.get_parameter("gain").value == 3.0


def test_while_a_transition_runs_another_one_is_refused_at_once() -> None:
    class Slow(Camera):
        may_end = threading.Event()

        def on_cleanup(self, previous_state: State) -> CallbackReturn:
            assert self.may_end.wait(20)
            return CallbackReturn.SUCCESS

    manager = app(nodes_dict={"camera": Slow})

    def questions(client: Asker) -> None:
        assert client.ask("lifecycle.set", node="camera", transition="deactivate")["successful"]
        number = client.send("lifecycle.set", node="camera", transition="cleanup")
        with Asker(own_socket()) as other:
            wait_until(
                lambda: other.ask("lifecycle.get", node="camera")["state"] == "cleaningup", "it"
            )
            answer = other.answer("lifecycle.set", node="camera", transition="shutdown")
            assert answer["kind"] == "refused"
            assert answer["error"].startswith("busy: cleaningup since")
        Slow.may_end.set()
        assert client.read()[0]["id"] == number

    ask_while_running(manager, questions)


def test_an_interruption_in_a_change_ends_the_program_as_elsewhere() -> None:
    class Leaving(Camera):
        def on_cleanup(self, previous_state: State) -> CallbackReturn:
            raise SystemExit(7)

    manager = app(nodes_dict={"camera": Leaving})

    def questions(client: Asker) -> None:
        assert client.ask("lifecycle.set", node="camera", transition="deactivate")["successful"]
        answer = client.answer("lifecycle.set", node="camera", transition="cleanup")
        assert answer == {
            "id": client._number,
            "error": "the program was interrupted",
            "kind": "failed",
        }

    with pytest.raises(SystemExit) as caught:
        ask_while_running(manager, questions)
    assert caught.value.code == 7


def test_after_a_request_the_loop_sleeps_as_before() -> None:
    """The loop's cheap sleep is given up for ever after a call of another thread of its own."""
    manager = app(handlers_class=Handlers)
    executor = manager.backend.executor
    spins: list[int] = []
    spin_until = executor.spin_until

    class Counting:
        """An executor that counts how often it is spun."""

        def __getattr__(self, name: str) -> Any:
            return getattr(executor, name)

        def spin_until(self, deadline_ns: int, stopping: Any) -> None:
            spins.append(deadline_ns)
            spin_until(deadline_ns, stopping)

    def questions(client: Asker) -> None:
        for _ in range(5):
            assert client.ask("parameter.set", node="robot", values={"gain": 2})
        before = len(spins)
        ticks = told(client)["ticks"]
        wait_until(lambda: told(client)["ticks"] > ticks + 50, "some ticks")
        # One more where a tick came between the change and the callbacks that hear of it.
        assert len(spins) <= before + 2

    def run(_: object, *rest: Any) -> None:
        run_main_loop(Counting(), *rest)  # type: ignore[arg-type]  # it is one

    manager._run_loop = run
    ask_while_running(manager, questions)
    assert 1 <= len(spins) <= 12


# The log.


@pytest.fixture
def logs_info() -> None:
    """Has INFO logged, although pytest is an application that does not ask for it."""
    logging.getLogger("rosbase").setLevel(logging.INFO)


def lines(client: Asker, **arguments: Any) -> list[str]:
    count = client.ask("log", **arguments)["count"]
    found = [client.read()[0]["event"] for _ in range(count)]
    assert client.read()[0]["end"] == "done"
    return [f"{one['level']} {one['name']}: {one['text']}" for one in found]


@pytest.mark.usefixtures("logs_info")
def test_the_log_has_the_records_of_all_loggers_since_the_program_was_built() -> None:
    manager = app()
    manager.logger.info("zero")

    def questions(client: Asker) -> None:
        manager.logger.info("one")
        manager.node(Camera).logger.warning("two")
        manager.node(Robot).logger.debug("too quiet")
        try:
            raise ValueError("lens")
        except ValueError:
            manager.logger.exception("three")
        found = lines(client)
        assert found[:3] == ["20 app: zero", "20 app: one", "30 camera: two"]
        assert found[3].startswith("40 app: three\n  Traceback")
        assert found[3].endswith("ValueError: lens")
        assert lines(client, level="warn") == found[2:]
        assert lines(client, level=40) == found[3:]
        assert lines(client, last=1) == found[3:]
        assert lines(client, last=0) == []
        assert client.answer("log", level="loud")["kind"] == "invalid"
        assert client.answer("log", level=[])["kind"] == "invalid"
        assert client.answer("log", last=-1)["kind"] == "invalid"

    ask_while_running(manager, questions)
    assert not recent_log.lines
    manager.logger.info("too late")
    assert not recent_log.lines


@pytest.mark.usefixtures("logs_info")
def test_the_log_is_followed() -> None:
    manager = app()

    def questions(client: Asker) -> None:
        manager.logger.info("before")
        assert client.ask("log", follow=True, level="info")["count"] == 1
        assert client.read()[0]["event"]["text"] == "before"
        for number in range(50):
            manager.logger.debug("no")
            manager.logger.info(f"line {number}")
            event = client.read()[0]["event"]
            assert event["text"] == f"line {number}"
            assert event["stamp_ns"] > 10**18
        client.send("cancel", of=1)

        assert client.read()[0] == {"id": client._number, "ok": {}}
        assert client.read()[0] == {"id": 1, "end": "cancelled"}

    def with_another(_: Asker) -> None:
        with Asker(own_socket()) as another:
            questions(another)

    ask_while_running(manager, with_another)


@pytest.mark.usefixtures("logs_info")
def test_the_log_keeps_a_thousand_records_and_cuts_long_ones() -> None:
    manager = app()

    def questions(client: Asker) -> None:
        for number in range(1_500):
            manager.logger.info(f"line {number}")
        manager.logger.info("x" * 9_500)
        found = lines(client)
        assert len(found) == 1_000
        assert found[0] == "20 app: line 501"
        assert "\n... 1308 more characters\n... " in found[-1]
        assert len(found[-1]) < 8_300

    ask_while_running(manager, questions)


@pytest.mark.usefixtures("logs_info")
def test_a_follower_that_does_not_read_loses_the_oldest_and_is_told_how_many() -> None:
    manager = app()
    text = "x" * 5_000

    def questions(client: Asker) -> None:
        with Asker(own_socket()) as slow:
            slow.ask("log", follow=True)
            for number in range(3_000):
                manager.logger.info(f"{number} {text}")
            events, seen = [], -1
            while seen < 2_999:
                events.append(slow.read()[0]["event"])
                seen = int(events[-1]["text"].split()[0])
            lost = 3_000 - len(events)
            assert lost > 500
            assert events[-1]["dropped"] == lost
            assert client.ask("process")["dropped"] == lost

    ask_while_running(manager, questions)


@pytest.mark.usefixtures("logs_info")
def test_a_handler_of_the_application_changes_nothing(tmp_path: Path) -> None:
    handler = logging.FileHandler(tmp_path / "log")
    logging.getLogger("rosbase").addHandler(handler)
    manager = app()

    def questions(client: Asker) -> None:
        manager.logger.info("one")
        assert lines(client) == ["20 app: one"]

    try:
        ask_while_running(manager, questions)
    finally:
        handler.close()


@pytest.mark.usefixtures("logs_info")
def test_a_logger_of_the_application_is_heard_too() -> None:
    class Own:
        def __init__(self, name: str) -> None:
            self.said: list[str] = []

        def info(self, text: str) -> None:
            self.said.append(text)

    manager = app(custom_logger=Own)

    def questions(client: Asker) -> None:
        manager.logger.info("one")
        assert lines(client) == ["20 app: one"]

    ask_while_running(manager, questions)


# Statistics.


def test_statistics_tell_the_distribution_of_period_and_work() -> None:
    def questions(client: Asker) -> None:
        wait_until(lambda: told(client)["ticks"] > 20, "some ticks")
        (found,) = client.ask("statistics")["programs"]
        assert found["program"] == "/app"
        assert found["rate_hz"] == 100.0
        for what in ("period", "busy"):
            one = found[what]
            assert one["count"] == sum(count for _, count in one["histogram"])
            assert 0 < one["min_ns"] <= one["p50"] <= one["p90"] <= one["p99"] <= one["p999"]
            assert one["p999"] <= one["max_ns"]
            uppers = [upper for upper, _ in one["histogram"]]
            assert uppers == sorted(uppers)
        assert found["ticks"] > 20
        assert 5_000_000 < found["period"]["p50"] < 20_000_000
        assert client.ask("statistics", program="app")["programs"][0]["program"] == "/app"
        assert client.answer("statistics", program="ap")["kind"] == "unknown"

    ask(questions)
