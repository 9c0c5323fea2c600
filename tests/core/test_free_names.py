"""The base classes leave the names free that programs use for what is theirs."""

from typing import Any

import pytest

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode, LifecycleNode
from rosbase.testing import virtual_backend
from support.roles import StopAfter

WORDS = """
    action agent auto cfg commands done duration grasp handle joystick latest left missing name node
    publish ready reset right robot select start step timer turn up
"""
NAMES = WORDS.split()


class Agent(BaseAgent):
    def reset(self) -> None: ...


BASES = [BaseNode, LifecycleNode, Agent, BaseHandlers]
COMBINATIONS = [
    pytest.param(base, name, id=f"{base.__name__}-{name}")
    for base in BASES
    for name in NAMES
    # What is called once per tick is that.
    if (base, name) != (BaseHandlers, "handle")
]


class App(BaseManager):
    """Ticks three times, whatever is in it."""

    def update_timestamp(self) -> None:
        super().update_timestamp()
        if self.timestamp == 3:
            self.request_stop()


def after_a_run(component: Any) -> Any:
    """The component that a manager made of that class, after its main loop."""
    if issubclass(component, BaseHandlers):
        app = App(handlers_class=component, backend=virtual_backend())
    elif issubclass(component, BaseNode):
        app = App(nodes_dict={"it": component}, backend=virtual_backend())
    else:
        app = App(agents_dict={"it": component}, backend=virtual_backend())
    app.start_main_loop_timer()
    return app.handlers or (app.nodes | app.agents)["it"]


@pytest.mark.parametrize(("base", "name"), COMBINATIONS)
def test_programs_may_assign_the_name_in_their_init(base: Any, name: str) -> None:
    class Component(base):  # type: ignore[misc]  # the base is a parameter
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            setattr(self, name, "before")
            super().__init__(manager, **kwargs)
            self.found = getattr(self, name)
            setattr(self, name, "after")

    it = after_a_run(Component)
    assert (it.found, getattr(it, name)) == ("before", "after")


@pytest.mark.parametrize(("base", "name"), COMBINATIONS)
def test_programs_may_have_the_name_on_their_class(base: Any, name: str) -> None:
    assert getattr(after_a_run(type("Component", (base,), {name: 5})), name) == 5


def test_a_node_with_getattr_is_never_asked_for_what_does_not_exist() -> None:
    asked: list[str] = []

    class Proxy(BaseNode):
        def __getattr__(self, name: str) -> Any:
            asked.append(name)
            raise AttributeError(name)

    manager = BaseManager(
        nodes_dict={"proxy": Proxy}, handlers_class=StopAfter, backend=virtual_backend()
    )
    manager.start_main_loop_timer()
    lone = Proxy(backend=virtual_backend())
    lone.create_timer(0.1, lone._request_stop)
    lone.start_spin_standalone()
    assert asked == []


def test_a_node_may_skip_the_init_of_its_base() -> None:
    class Own(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            self.value = 1

    class Handlers(StopAfter):
        def handle(self) -> None:
            self.nodes["own"].value += 1
            super().handle()

    manager = BaseManager(
        nodes_dict={"own": Own}, handlers_class=Handlers, backend=virtual_backend()
    )
    manager.start_main_loop_timer()
    assert manager.nodes["own"].value == 6


@pytest.mark.parametrize("base", [BaseManager, *BASES], ids=lambda base: base.__name__)
def test_a_component_is_true_however_empty(base: Any) -> None:
    assert not hasattr(base, "__len__")
    assert not hasattr(base, "__bool__")


def test_the_abstract_reset_of_an_agent_is_callable_through_super() -> None:
    class Careful(BaseAgent):
        steps = 3

        def reset(self) -> None:
            super().reset()  # type: ignore[safe-super]  # it has a body, though abstract
            self.steps = 0

    agent = Careful()
    agent.reset()
    assert agent.steps == 0
