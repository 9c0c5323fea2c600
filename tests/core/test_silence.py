"""What used to go wrong without a word is said in one line."""

import functools
import logging
import re
import subprocess
import sys
import textwrap
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from rosbase import (
    BaseAgent,
    BaseHandlers,
    BaseManager,
    BaseNode,
    CallbackReturn,
    LifecycleNode,
    Parameter,
    SetParametersResult,
    State,
    register_multiprocess_nodes,
)
from rosbase.errors import HandshakeTimeoutError, TransitionNotAvailableError
from rosbase.messages import Header
from rosbase.testing import virtual_backend
from support.roles import StopAfter


class Device(LifecycleNode):
    autostart = "activate"


class Broken(Device):
    def on_activate(self, previous_state: State) -> CallbackReturn:
        self.last_error = OSError("no current")
        return CallbackReturn.ERROR


def run(nodes: dict[str, type[BaseNode]], handlers: type[BaseHandlers] = StopAfter) -> BaseManager:
    manager = BaseManager("robot", nodes, None, handlers, backend=virtual_backend())
    manager.start_main_loop_timer()
    return manager


def test_an_error_that_a_callback_answers_is_logged_with_node_and_reason(
    caplog: pytest.LogCaptureFixture,
) -> None:
    run({"arm": Broken})
    said = ("rosbase.arm", logging.ERROR, "on_activate answered ERROR: no current")
    assert said in caplog.record_tuples


def test_an_error_without_a_reason_says_how_to_give_one(caplog: pytest.LogCaptureFixture) -> None:
    class Silent(Device):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            return CallbackReturn.ERROR

    run({"arm": Silent})
    expected = "on_configure answered ERROR: no reason (set last_error to give one)"
    assert ("rosbase.arm", logging.ERROR, expected) in caplog.record_tuples


def test_a_raised_error_is_logged_with_node_state_and_reason(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class Handlers(StopAfter):
        def handle(self) -> None:
            if self.timestamp == 1:
                self.nodes["arm"].raise_error(RuntimeError("the belt is torn"))
            super().handle()

    run({"arm": Device}, Handlers)
    said = ("rosbase.arm", logging.ERROR, "error in active: RuntimeError: the belt is torn")
    assert said in caplog.record_tuples


def test_nodes_that_were_not_brought_up_because_another_failed_are_named(
    caplog: pytest.LogCaptureFixture,
) -> None:
    run({"a": Device, "b": Device, "c": Broken, "d": Device, "e": Device})
    expected = "c was not brought up; taken down again: b, a; not tried: d, e"
    assert expected in caplog.messages


def test_a_rule_that_waits_for_a_node_which_is_not_active_yet_says_so() -> None:
    manager = BaseManager(nodes_dict={"camera": Device}, backend=virtual_backend())
    manager.add_handshake_rule("first image", lambda: False)
    expected = "still waiting for: first image (brought up only after the handshake: camera)"
    with pytest.raises(HandshakeTimeoutError, match=re.escape(expected)):
        manager.start_main_loop_timer()


def test_subscriptions_and_timers_of_a_lifecycle_node_run_in_every_state() -> None:
    calls: list[str] = []

    class Listens(LifecycleNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.create_subscription(Header, "image", lambda _: calls.append("message"), 10)
            self.create_timer(0.01, lambda: calls.append("timer"))
            manager.backend.create_publisher(Header, "image", 10).publish(Header())

    manager = run({"eye": Listens})
    assert manager.nodes["eye"].get_state() is State.FINALIZED
    assert {"message", "timer"} <= set(calls)


async def coroutine(*_: object) -> None: ...


def generator(*_: object) -> Any:
    yield


async def stream(*_: object) -> Any:
    yield


class Waits:
    async def __call__(self, *_: object) -> None: ...


def call(function: Callable[[], object]) -> object:
    return function()


NEVER_RUN: list[Any] = [coroutine, generator, stream, functools.partial(coroutine, 1), Waits()]


@pytest.mark.parametrize("callback", NEVER_RUN, ids=lambda c: getattr(c, "__name__", repr(c)[:12]))
@pytest.mark.parametrize("kind", ["subscription", "timer", "rule"])
def test_a_callback_that_would_never_run_is_refused_when_it_is_created(
    kind: str, callback: Any
) -> None:
    manager = BaseManager(nodes_dict={"n": BaseNode}, backend=virtual_backend())
    node: BaseNode = manager.nodes["n"]
    create: dict[str, Callable[[], object]] = {
        "subscription": lambda: node.create_subscription(Header, "image", callback, 1),
        "timer": lambda: node.create_timer(0.1, callback),
        "rule": lambda: manager.add_handshake_rule("ready", callback),
    }
    with pytest.raises(TypeError, match=r"is async|is a generator"):
        create[kind]()
    manager.destroy_node()


@pytest.mark.parametrize("callback", [None, "keep", 3])
def test_what_cannot_be_called_is_refused_when_it_is_created(callback: Any) -> None:
    manager = BaseManager(nodes_dict={"n": BaseNode}, backend=virtual_backend())
    with pytest.raises(TypeError, match="the subscription to image takes a function"):
        manager.nodes["n"].create_subscription(Header, "image", callback, 1)
    manager.destroy_node()


def test_handlers_whose_handle_is_async_are_refused() -> None:
    class Handlers(BaseHandlers):
        async def handle(self) -> None:  # type: ignore[override]  # the mistake is the test
            ...

    with pytest.raises(TypeError, match=r"Handlers\.handle: .* is async"):
        BaseManager(handlers_class=Handlers, backend=virtual_backend())


METHODS: list[tuple[type, str]] = [
    (BaseManager, "init_custom_variables"),
    (BaseManager, "handshake"),
    (BaseManager, "main_loop"),
    (BaseManager, "get_state_switch"),
    (BaseManager, "state_handle"),
    (BaseManager, "update_timestamp"),
    (BaseManager, "release_resources"),
    (BaseNode, "release_resources"),
    (BaseAgent, "reset"),
    (BaseHandlers, "handle"),
    (LifecycleNode, "on_configure"),
    (LifecycleNode, "on_activate"),
    (LifecycleNode, "on_deactivate"),
    (LifecycleNode, "on_cleanup"),
    (LifecycleNode, "on_shutdown"),
    (LifecycleNode, "on_error"),
]


@pytest.mark.parametrize("function", [coroutine, generator, stream], ids=lambda f: f.__name__)
@pytest.mark.parametrize(("base", "name"), METHODS, ids=lambda x: getattr(x, "__name__", x))
def test_a_method_that_would_never_run_is_refused_when_its_owner_is_built(
    base: type, name: str, function: Any
) -> None:
    owner: Any = type("Mine", (base,), {name: function})
    options = {"backend": virtual_backend()} if issubclass(base, (BaseManager, BaseNode)) else {}
    with pytest.raises(TypeError, match=rf"^Mine\.{name}: \w+ is (async|a generator)"):
        owner(**options)


@pytest.mark.parametrize("kind", ["nodes_dict", "agents_dict"])
def test_a_method_that_a_constructor_replaces_is_refused(kind: str) -> None:
    class Device(LifecycleNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.on_activate: Any = coroutine

    class Plain:
        reset = coroutine

        def __init__(self, manager: Any = None, **kwargs: Any) -> None: ...

    components: Any = {kind: {"one": Device if kind == "nodes_dict" else Plain}}
    with pytest.raises(TypeError, match=r"^(Device.on_activate|Plain.reset): coroutine is async"):
        BaseManager(backend=virtual_backend(), **components)


@pytest.mark.parametrize("name", ["get_state_switch", "state_handle"])
def test_an_async_switch_that_is_set_after_the_constructor_is_refused(name: str) -> None:
    manager = BaseManager(handlers_class=StopAfter, backend=virtual_backend())
    setattr(manager, name, coroutine)
    with pytest.raises(TypeError, match=rf"^BaseManager\.{name}: coroutine is async"):
        manager.start_main_loop_timer()


@pytest.mark.parametrize("function", [coroutine, generator, stream], ids=lambda f: f.__name__)
@pytest.mark.parametrize("where", ["rule", "handshake", "get_state_switch"])
def test_a_coroutine_is_not_an_answer(where: str, function: Any) -> None:
    class App(BaseManager):
        pass

    if where != "rule":
        setattr(App, where, lambda self: function())
    manager = App(handlers_class=StopAfter, backend=virtual_backend())
    what = f"App.{where}"
    if where == "rule":
        manager.add_handshake_rule("ready", functools.partial(call, function))
        what = "handshake rule 'ready'"
    kind = "coroutine" if function is coroutine else "generator"
    expected = rf"^{what} returned the {kind} {function.__name__}, "
    with pytest.raises(TypeError, match=expected):
        manager.start_main_loop_timer()


@pytest.mark.parametrize("function", [coroutine, generator, stream], ids=lambda f: f.__name__)
@pytest.mark.parametrize("where", ["Ticks.handle", "App.state_handle"])
def test_a_tick_that_returns_a_coroutine_is_reported_once(
    where: str, function: Any, caplog: pytest.LogCaptureFixture
) -> None:
    class App(BaseManager):
        pass

    class Ticks(StopAfter):
        def handle(self) -> Any:
            super().handle()
            return function() if where == "Ticks.handle" else 3

    if where == "App.state_handle":
        App.state_handle = lambda self: function()
    manager = App(handlers_class=Ticks, backend=virtual_backend())
    manager.start_main_loop_timer()
    assert manager.timestamp > 1
    kind = "coroutine" if function is coroutine else "generator"
    (said,) = [record for record in caplog.records if "returned" in record.getMessage()]
    assert said.getMessage().startswith(f"{where} returned the {kind} {function.__name__}, ")
    assert said.levelname == "ERROR"


def test_a_transition_asked_for_during_another_is_refused_and_says_which_and_since_when() -> None:
    class Asks(LifecycleNode):
        def on_configure(self, previous_state: State) -> CallbackReturn:
            self.get_clock().sleep(3.2)
            with pytest.raises(TransitionNotAvailableError, match=r"^busy: configuring since 3 s$"):
                self.trigger_activate()
            return CallbackReturn.SUCCESS

    node = Asks(backend=virtual_backend())
    assert node.trigger_configure() is CallbackReturn.SUCCESS
    assert node.describe_transition() == ""
    node.destroy_node()


class Goes(BaseHandlers):
    def __init__(self, manager: Any = None, *, goal: float = 0.0, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.speed = kwargs.get("speed", 1.0)


@pytest.mark.parametrize(
    ("argument", "said"),
    [
        ("hanshake_timeout", "; did you mean handshake_timeout?"),
        ("gaol", "; did you mean goal?"),
        ("colour", ""),
        ("sped", "; did you mean speed?"),
        ("handlers", "; did you mean handlers_class?"),
        ("nodes", "; did you mean nodes_dict?"),
        ("node_hz", "; did you mean node_freq_hz?"),
    ],
)
def test_a_keyword_argument_that_nothing_takes_is_named(
    argument: str, said: str, caplog: pytest.LogCaptureFixture
) -> None:
    values: dict[str, Any] = {argument: 1}
    BaseManager(handlers_class=Goes, backend=virtual_backend(), **values).destroy_node()
    assert caplog.messages == [f"nothing takes the keyword argument {argument}{said}"]


def test_keyword_arguments_that_something_takes_are_not_named(
    caplog: pytest.LogCaptureFixture,
) -> None:
    class App(BaseManager):
        def __init__(self, *, lens: str, **kwargs: Any) -> None:
            super().__init__(lens=lens, **kwargs)

    values: dict[str, Any] = {"goal": 1.0, "speed": 2.0, "lens": "wide"}
    App(handlers_class=Goes, backend=virtual_backend(), **values).destroy_node()
    assert caplog.messages == []


class Lens(BaseNode):
    def __init__(self, manager: Any = None, *, focus: float = 0.0, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.zoom = kwargs.get("zoom", 1.0)


@pytest.mark.parametrize("base", [BaseNode, LifecycleNode, Lens])
def test_a_keyword_argument_that_a_standalone_node_does_not_take_is_named(
    base: Any, caplog: pytest.LogCaptureFixture
) -> None:
    base(backend=virtual_backend(), node_nam="q", lens=3).destroy_node()
    assert caplog.messages == [
        "nothing takes the keyword argument node_nam; did you mean node_name?",
        "nothing takes the keyword argument lens",
    ]


def test_what_a_standalone_node_takes_is_not_named(caplog: pytest.LogCaptureFixture) -> None:
    Lens(backend=virtual_backend(), node_name="q", focus=2.0, zoom=3.0).destroy_node()
    assert caplog.messages == []


def test_an_instance_given_for_a_class_is_one_clear_line() -> None:
    class Planner(BaseAgent):
        def reset(self) -> None: ...

    planner: Any = Planner()
    with pytest.raises(
        TypeError,
        match=r"^agents_dict\['plan'\] is an instance of Planner; give the class, Planner$",
    ):
        BaseManager(agents_dict={"plan": planner}, backend=virtual_backend())


def test_an_instance_given_for_the_class_of_a_child_is_one_clear_line() -> None:
    node = BaseNode(backend=virtual_backend())
    with pytest.raises(
        TypeError,
        match=r"^mp_nodes_dict\['p'\] is an instance of BaseNode; give the class, BaseNode$",
    ):
        register_multiprocess_nodes({"p": node})
    with pytest.raises(TypeError, match=r"^mp_nodes_dict\['p'\] is 'Camera'; give a class$"):
        register_multiprocess_nodes({"p": "Camera"})
    node.destroy_node()


def test_what_is_no_class_at_all_is_named() -> None:
    nodes: Any = {"eye": "Camera"}
    with pytest.raises(TypeError, match=r"nodes_dict\['eye'\] is 'Camera'; give a class"):
        BaseManager(nodes_dict=nodes, backend=virtual_backend())


class Forgets(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        self.image = None


class ForgetsAndUses(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        self.create_publisher(Header, "image", 1)


class ForgetsAndLogs(BaseHandlers):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        self.logger.info("here")


def test_a_constructor_that_never_calls_the_one_of_its_base_is_named(
    caplog: pytest.LogCaptureFixture,
) -> None:
    BaseManager(nodes_dict={"eye": Forgets}, backend=virtual_backend()).destroy_node()
    (said,) = caplog.messages
    assert said.startswith("Forgets.__init__ does not call super().__init__(manager")


@pytest.mark.parametrize("forgetful", [ForgetsAndUses, ForgetsAndLogs])
def test_a_missing_call_of_the_base_constructor_is_one_clear_line(forgetful: Any) -> None:
    where = {"handlers_class": forgetful}
    if issubclass(forgetful, BaseNode):
        where = {"nodes_dict": {"eye": forgetful}}
    with pytest.raises(
        (TypeError, AttributeError), match=rf"{forgetful.__name__}.__init__ .*super"
    ):
        BaseManager(backend=virtual_backend(), **where)


class ForgetsAsMixin:
    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self.y = 2


class ForgetfulDevice(Device):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        self.y = 2


class MixedDevice(ForgetsAsMixin, Device):
    pass


class LateDevice(Device):
    """Gets its constructor after its class, as from a decorator."""


LateDevice.__init__ = ForgetsAsMixin.__init__  # type: ignore[assignment]  # as a decorator does

FORGETFUL_DEVICES = [ForgetfulDevice, MixedDevice, LateDevice]


@pytest.mark.parametrize("forgetful", FORGETFUL_DEVICES)
def test_a_lifecycle_node_may_not_leave_out_the_constructor_of_its_base(forgetful: Any) -> None:
    expected = rf"^{forgetful.__name__}.__init__ must first call super\(\).__init__"
    with pytest.raises(TypeError, match=expected):
        BaseManager(nodes_dict={"arm": Device, "bad": forgetful}, backend=virtual_backend())
    with pytest.raises((TypeError, AttributeError), match=expected):
        forgetful().start_spin_standalone()


class ForgetfulManager(BaseManager):
    def __init__(self, **kwargs: Any) -> None:
        self.y = 2


class MixedManager(ForgetsAsMixin, BaseManager):
    pass


class LaterManager(BaseManager):
    """Gets its constructor after its class, as from a decorator."""


LaterManager.__init__ = ForgetsAsMixin.__init__  # type: ignore[assignment]  # as a decorator does


@pytest.mark.parametrize("forgetful", [ForgetfulManager, MixedManager, LaterManager])
def test_a_manager_may_not_leave_out_the_constructor_of_its_base(forgetful: Any) -> None:
    expected = rf"^{forgetful.__name__}.__init__ must first call super\(\).__init__"
    with pytest.raises((TypeError, AttributeError), match=expected):
        forgetful().start_main_loop_timer()


@pytest.mark.parametrize(
    "use",
    [
        lambda app: app.add_handshake_rule("ready", bool),
        lambda app: app.request_stop(),
        lambda app: app.logger.info("here"),
        lambda app: app.nodes["eye"],
        lambda app: app.start_main_loop_timer(),
        lambda app: app.destroy_node(),
    ],
    ids=["rule", "stop", "logger", "nodes", "start", "destroy"],
)
def test_a_manager_that_calls_the_constructor_of_its_base_too_late_is_told_so(use: Any) -> None:
    class Late(BaseManager):
        def __init__(self) -> None:
            use(self)
            super().__init__(backend=virtual_backend())

    with pytest.raises(AttributeError, match=r"^Late.__init__ must first call super") as raised:
        Late()
    last_line = traceback.format_exception_only(raised.value)[-1]
    assert "Did you mean" not in last_line


@pytest.mark.parametrize(
    "cls", [BaseManager, BaseNode, BaseAgent, BaseHandlers, LifecycleNode, Device]
)
def test_attributes_are_found_as_in_any_class(cls: type) -> None:
    # With either, Python 3.10 and 3.11 take twice as long for each attribute of an object.
    assert not hasattr(cls, "__getattr__")
    assert not any("__getattribute__" in vars(one) for one in cls.__mro__[:-1])


def test_what_the_constructor_sets_is_no_attribute_of_the_class() -> None:
    @dataclass
    class Gripper(BaseNode):
        manager: Any
        name: str
        width_m: float = 0.1

        def __post_init__(self) -> None:
            super().__init__(self.manager)

    assert not hasattr(BaseNode, "logger")
    assert not hasattr(BaseManager, "nodes")
    with pytest.raises(TypeError, match="missing 1 required positional argument: 'name'"):
        Gripper(None)  # type: ignore[call-arg]  # the mistake is the test
    gripper = Gripper(None, "left")
    assert (gripper.name, gripper.width_m) == ("left", 0.1)
    gripper.destroy_node()


def test_what_a_manager_lacks_is_said_as_python_says_it() -> None:
    app = BaseManager(backend=virtual_backend())
    with pytest.raises(AttributeError, match="'BaseManager' object has no attribute 'ndoes'"):
        app.ndoes  # type: ignore[attr-defined]  # noqa: B018 - the access is the test
    app.destroy_node()


def test_whatever_is_wrong_with_one_node_the_others_are_taken_down() -> None:
    class Hollow(Device):
        """Loses all that is its own."""

        def on_activate(self, previous_state: State) -> CallbackReturn:
            self.__dict__.clear()
            return CallbackReturn.SUCCESS

    manager = BaseManager(
        nodes_dict={"arm": Device, "bad": Hollow, "leg": Device}, backend=virtual_backend()
    )
    with pytest.raises(AttributeError):
        manager.start_main_loop_timer()
    ends = [manager.nodes[name].get_state() for name in ("arm", "leg")]
    assert ends == [State.FINALIZED, State.FINALIZED]


def answers_none(parameters: object) -> None: ...


def answers_a_class(parameters: object) -> Any:
    return SetParametersResult


def divides_by_zero(parameters: object) -> Any:
    return 1 / 0


@pytest.mark.parametrize(
    ("callback", "said"),
    [
        (answers_none, "answers_none must return a SetParametersResult, not None"),
        (lambda _: True, "<lambda> must return a SetParametersResult, not True"),
        (answers_a_class, "answers_a_class must return a SetParametersResult, not <class"),
        (divides_by_zero, "divides_by_zero raised ZeroDivisionError: division by zero"),
    ],
)
def test_a_parameter_callback_that_fails_refuses_the_change_and_is_named_in_one_line(
    callback: Any, said: str, caplog: pytest.LogCaptureFixture
) -> None:
    node = BaseNode(backend=virtual_backend())
    node.declare_parameter("rate", 1)
    node.add_on_set_parameters_callback(callback)
    result = node.set_parameters([Parameter("rate", 2)])
    assert not result.successful
    assert said in result.reason
    assert node.get_parameter("rate").value == 1
    (line,) = caplog.messages
    assert said in line
    node.destroy_node()


def test_what_a_component_lacks_is_said_as_python_says_it() -> None:
    node = BaseNode(backend=virtual_backend())
    with pytest.raises(AttributeError, match="'BaseNode' object has no attribute 'imgae'"):
        node.imgae  # type: ignore[attr-defined]  # noqa: B018 - the access is the test
    node.destroy_node()


HANGS = """
import time
from rosbase import BaseHandlers, BaseManager, BaseNode, CallbackReturn, LifecycleNode
from rosbase.messages import Header
from rosbase.testing import virtual_backend

class Echo(BaseNode):
    def __init__(self, manager=None, **kwargs):
        super().__init__(manager, **kwargs)
        self.out = self.create_publisher(Header, "ball", 1)
        self.create_subscription(Header, "ball", lambda ball: self.out.publish(ball), 1)
        self.out.publish(Header())

class Sleeps(BaseHandlers):
    def handle(self):
        time.sleep(1000)

class StopsAtThree(BaseHandlers):
    def handle(self):
        if self.timestamp == 3:
            self.manager.request_stop()

class Catches(BaseHandlers):
    def handle(self):
        while True:
            try:
                time.sleep(1)
            except Exception:
                pass

class CatchesAll(StopsAtThree):
    def handle(self):
        if self.timestamp == 1:
            try:
                time.sleep(1000)
            except BaseException:
                pass
        super().handle()

class SlowDevice(LifecycleNode):
    autostart = "activate"
    def on_configure(self, previous_state):
        time.sleep(1000)
        return CallbackReturn.SUCCESS

def manager(**more):
    return BaseManager(backend=virtual_backend(), **more)

def test_handshake():
    app = manager()
    app.add_handshake_rule("first image", lambda: False)
    app.start_main_loop_timer()

def test_feeding():
    manager(nodes_dict={"a": Echo, "b": Echo}).start_main_loop_timer()

def test_endless():
    manager(handlers_class=BaseHandlers).start_main_loop_timer()

def test_sleep():
    manager(handlers_class=Sleeps).start_main_loop_timer()

def test_device():
    nodes = {"arm": SlowDevice}
    manager(nodes_dict=nodes, handlers_class=StopsAtThree).start_main_loop_timer()

def test_alone():
    SlowDevice(backend=virtual_backend()).start_spin_standalone()

def test_rule():
    app = manager(handlers_class=StopsAtThree)
    app.add_handshake_rule("sleepy", lambda: time.sleep(1000))
    app.start_main_loop_timer()

def test_catching():
    manager(handlers_class=Catches).start_main_loop_timer()

def test_caught():
    manager(handlers_class=CatchesAll).start_main_loop_timer()
"""

REASONS = {
    "handshake": "HandshakeTimeoutError: after 60.0 s still waiting for: first image",
    "feeding": "virtual time stands still|TimeoutError: after 6 s of real time",
    "endless": "TimeoutError: after 6 s of real time .*: nobody stops it",
    "sleep": r"TimeoutError: after 6 s of real time .*: Sleeps.handle is running \(.*:16\)",
    "device": "TimeoutError: after 6 s of real time .*: SlowDevice.on_configure is running",
    "alone": "TimeoutError: after 6 s of real time .*: SlowDevice.on_configure is running",
    "rule": "TimeoutError: after 6 s of real time .*: test_rule.<locals>.<lambda> is running",
    "catching": "TimeoutError: after 6 s of real time .*: Catches.handle is running",
    "caught": "TimeoutError: after 6 s of real time .*: CatchesAll.handle is running",
}


def _as_named(reason: str) -> str:
    """Before Python 3.11, code does not know of which class it is."""
    if sys.version_info >= (3, 11):
        return reason
    return re.sub(r"[\w.<>]+\.(?=[\w<>]+ is running)", "", reason)


def pytest_process(folder: Path, name: str) -> "subprocess.Popen[str]":
    (folder / "test_hangs.py").write_text(textwrap.dedent(HANGS))
    return subprocess.Popen(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:timeout", "-k", name, "test_hangs.py"],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


@pytest.mark.once
@pytest.mark.parametrize("name", list(REASONS))
def test_a_test_that_hangs_in_virtual_time_fails_with_a_reason(name: str, tmp_path: Path) -> None:
    with pytest_process(tmp_path, name) as process:
        started = time.monotonic()
        out, _ = process.communicate(timeout=20)
        took_s = time.monotonic() - started
    assert process.returncode == 1
    assert re.search(_as_named(REASONS[name]), out), out
    # Python and pytest need a moment to start, on a busy machine a longer one.
    assert took_s < 20


def test_ctrl_c_ends_pytest_and_passes_no_test_that_hangs(tmp_path: Path) -> None:
    signalling = 'open("there", "w").close(); time.sleep(1000)'
    source = HANGS.replace("time.sleep(1000)", signalling, 1)
    with pytest_process(tmp_path, "sleep") as process:
        (tmp_path / "test_hangs.py").write_text(source)
        deadline = time.monotonic() + 20
        while not (tmp_path / "there").exists() and time.monotonic() < deadline:
            time.sleep(0.02)
        process.send_signal(2)
        out, _ = process.communicate(timeout=20)
    assert process.returncode == 2, out
    assert "KeyboardInterrupt" in out
    assert "passed" not in out
