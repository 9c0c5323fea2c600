"""Every node of a manager has a name, parameters and a log of its own."""

from collections.abc import Callable
from typing import Any

import pytest

from rosbase.contracts.backend import BackendOptions
from rosbase.errors import BackendError, ParameterError
from rosbase.local import LocalBackend
from rosbase.local.bus import Bus
from rosbase.manager import BaseManager
from rosbase.messages import String
from rosbase.parameters import Parameter, SetParametersResult
from rosbase.roles.agent import BaseAgent
from rosbase.roles.lifecycle_node import LifecycleNode
from rosbase.roles.node import BaseNode
from rosbase.testing import ManualClock


class Camera(BaseNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.fps = self.declare_parameter("fps", 30).value


class Arm(LifecycleNode):
    def __init__(self, manager: Any = None, **kwargs: Any) -> None:
        super().__init__(manager, **kwargs)
        self.speed = self.declare_parameter("speed", 1.0).value


def manager(
    nodes: dict[str, Callable[..., Any]], overrides: dict[str, Any] | None = None, **kwargs: Any
) -> BaseManager:
    backend = LocalBackend(BackendOptions("robot", overrides or {}, ManualClock()), Bus())
    return BaseManager("robot", nodes, backend=backend, **kwargs)  # type: ignore[arg-type]  # any


def test_two_nodes_of_one_class_have_a_name_and_parameters_of_their_own() -> None:
    app = manager({"front": Camera, "rear": Camera}, {"rear.fps": 15})
    front, rear = app.nodes["front"], app.nodes["rear"]
    assert (front.name, rear.name) == ("front", "rear")
    assert (front.fps, rear.fps) == (30, 15)
    assert front.set_parameter("fps", 25).successful
    assert front.get_parameter("fps") == Parameter("fps", 25)
    assert rear.get_parameter("fps") == Parameter("fps", 15)


@pytest.mark.parametrize("node_class", [Camera, Arm])
def test_a_refusal_names_the_node_and_the_parameter(node_class: Any) -> None:
    app = manager({"front": node_class})
    refused = app.nodes["front"].set_parameter("focus", 1)
    assert refused.reason == "parameter front.focus has not been declared"
    with pytest.raises(ParameterError, match=r"parameter front\.focus has not been declared"):
        app.nodes["front"].get_parameter("focus")
    with pytest.raises(ParameterError, match=r"parameter front\.fps takes a whole number"):
        manager({"front": Camera}, {"front.fps": "fast"})


def test_callbacks_of_a_node_concern_its_own_parameters() -> None:
    app = manager({"front": Camera, "rear": Camera})
    asked: list[list[Parameter[Any]]] = []
    told: list[list[Parameter[Any]]] = []

    def judge(parameters: list[Parameter[Any]]) -> SetParametersResult:
        asked.append(parameters)
        return SetParametersResult(parameters[0].value != 13, "unlucky")

    app.nodes["front"].add_on_set_parameters_callback(judge)
    app.nodes["front"].add_post_set_parameters_callback(told.append)
    assert app.nodes["rear"].set_parameter("fps", 13).successful
    assert app.nodes["front"].set_parameter("fps", 13).reason == "unlucky"
    assert app.nodes["front"].set_parameter("fps", 14).successful
    while app.backend.spin_once(0.0):
        pass
    assert asked == [[Parameter("fps", 13)], [Parameter("fps", 14)]]
    assert told == [[Parameter("fps", 14)]]


def test_the_log_says_which_node_speaks(caplog: pytest.LogCaptureFixture) -> None:
    app = manager({"front": Camera, "arm": Arm, "robot": Arm})
    for node in app.nodes.values():
        node.logger.warning("here")
    names = [record.name.removeprefix("rosbase.") for record in caplog.records]
    assert names == ["robot.front", "arm", "robot"]


def test_nodes_share_a_logger_of_the_application() -> None:
    made: list[str] = []

    class Custom:
        def __init__(self, name: str) -> None:
            made.append(name)

        def say(self) -> str:
            return "said"

    app = manager({"front": Camera, "arm": Arm}, custom_logger=Custom)
    assert made == ["robot"]
    assert {node.logger.say() for node in app.nodes.values()} == {"said"}


def test_private_topics_of_a_lifecycle_node_are_below_its_own_name() -> None:
    app = manager({"front": Camera, "arm": Arm, "robot": Arm})
    topics = [n.create_publisher(String, "~/words").topic for n in app.nodes.values()]
    assert topics == ["/robot/words", "/arm/words", "/robot/words"]
    assert app.nodes["arm"].create_publisher(String, "{node}/words").topic == "/arm/words"


def test_a_lifecycle_node_with_the_name_of_the_manager_is_its_node() -> None:
    app = manager({"robot": Arm}, {"speed": 2})
    assert app.nodes["robot"].speed == 2.0
    assert app.backend.get_parameter("speed") == Parameter("speed", 2.0)


def test_a_name_that_ros_refuses_is_refused_for_a_lifecycle_node_only() -> None:
    with pytest.raises(BackendError, match="'left-arm' is not a node name"):
        manager({"left-arm": Arm})
    assert manager({"left-arm": Camera}).nodes["left-arm"].name == "left-arm"


def test_a_program_may_use_the_name_for_something_else() -> None:
    class Assigning(Camera):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            own: Any = self
            own.name = own.node = own.latest = "mine"

    class Having(Camera):
        @property
        def name(self) -> str:  # type: ignore[override]  # as programs do
            return "computed"

    app = manager({"front": Assigning, "rear": Having, "arm": Arm}, {"front.fps": 1, "rear.fps": 2})
    assert [node.name for node in app.nodes.values()] == ["mine", "computed", "arm"]
    assert [app.nodes[key].fps for key in ("front", "rear")] == [1, 2]
    assert repr(app.nodes["front"]) == "<Assigning 'front'>"


def test_a_node_that_a_node_builds_for_itself_takes_no_name() -> None:
    class Pair(Camera):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.helper = BaseNode(manager)
            self.helper.declare_parameter("fps", 5)

    app = manager({"pair": Pair}, {"pair.fps": 15, "fps": 7})
    assert app.nodes["pair"].fps == 15
    assert app.nodes["pair"].helper.get_parameter("fps").value == 7


def test_a_helper_that_a_node_builds_first_takes_no_name() -> None:
    class Kalman(BaseAgent):
        def reset(self) -> None:
            pass

    class Filtering(Camera):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            self.filter = Kalman(manager)
            super().__init__(manager, **kwargs)

    app = manager({"front": Filtering}, {"front.fps": 5})
    assert (app.nodes["front"].name, app.nodes["front"].fps) == ("front", 5)


def test_a_base_class_that_is_initialised_twice_keeps_the_name() -> None:
    class Eye(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            BaseNode.__init__(self, manager, **kwargs)
            self.declare_parameter("fps", 30)

    class Ear(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            BaseNode.__init__(self, manager, **kwargs)
            self.declare_parameter("gain", 1.0)

    class Head(Eye, Ear):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            Eye.__init__(self, manager, **kwargs)
            Ear.__init__(self, manager, **kwargs)

    head = manager({"head": Head}, {"head.fps": 5, "head.gain": 2}).nodes["head"]
    assert head.name == "head"
    assert [head.get_parameter(name).value for name in ("fps", "gain")] == [5, 2.0]


def test_the_node_of_the_manager_is_not_asked_about_others() -> None:
    app = manager({"robot": Arm, "front": Camera})
    asked: list[list[Parameter[Any]]] = []

    def refuse(parameters: list[Parameter[Any]]) -> SetParametersResult:
        asked.append(parameters)
        return SetParametersResult(successful=False, reason="no")

    app.nodes["robot"].add_on_set_parameters_callback(refuse)
    assert app.nodes["front"].set_parameter("fps", 25).successful
    assert app.nodes["robot"].set_parameter("speed", 2.0).reason == "no"
    assert asked == [[Parameter("speed", 2.0)]]


def test_agents_and_lone_nodes_have_names_too() -> None:
    class Planner(BaseAgent):
        def reset(self) -> None:
            pass

    assert manager({}, agents_dict={"planner": Planner}).agents["planner"].name == "planner"
    lone = Camera(node_name="eye", backend="local")
    assert lone.name == "eye"
    lone.destroy_node()


def test_parameter_defaults_are_for_every_node_or_for_one() -> None:
    app = manager(
        {"front": Camera, "rear": Camera, "arm": Arm},
        {"rear.fps": 5},
        parameter_defaults={"fps": 20, "rear.fps": 10, "arm.speed": 2},
    )
    assert [app.nodes[key].fps for key in ("front", "rear")] == [20, 5]
    assert app.nodes["arm"].speed == 2.0
    with pytest.raises(ParameterError, match="parameter fps takes a whole number"):
        manager({"front": Camera}, parameter_defaults={"fps": "fast"})


def test_a_stand_in_for_a_manager_needs_only_what_the_node_uses() -> None:
    class StandIn:
        def __init__(self) -> None:
            self.backend = LocalBackend(BackendOptions("test"), Bus())
            self.logger = None

    stand_in = StandIn()
    node = Camera(stand_in)
    assert node.fps == 30
    stand_in.backend.close()


def test_an_undeclared_override_names_the_parameter_of_the_node(
    caplog: pytest.LogCaptureFixture,
) -> None:
    app = manager({"front": Camera}, {"front.fsp": 5, "fps": 6})
    while app.backend.spin_once(0.0):
        pass
    said = "parameter front.fsp is set from outside, but this node does not declare it"
    assert caplog.messages == [f"{said}; did you mean front.fps?"]


def test_an_override_without_a_node_is_for_every_node() -> None:
    app = manager({"front": Camera, "rear": Camera, "arm": Arm}, {"fps": 5, "rear.fps": 6})
    assert [app.nodes[key].fps for key in ("front", "rear")] == [5, 6]
