"""A component is found by its class."""

from collections.abc import Callable, Mapping
from typing import Any

import pytest

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode
from rosbase.testing import virtual_backend


class Camera(BaseNode):
    pass


class DepthCamera(Camera):
    pass


class Lidar(BaseNode):
    pass


class Pilot(BaseAgent):
    def reset(self) -> None: ...


def built(nodes: Mapping[str, type[BaseNode]], agents: Mapping[str, Any] | None = None) -> Any:
    manager = BaseManager("app", nodes, agents, BaseHandlers, backend=virtual_backend())
    manager.destroy_node()
    return manager


def refusal(find: Callable[[], object]) -> str:
    with pytest.raises(LookupError) as refused:
        find()
    return str(refused.value)


def test_the_only_node_of_a_class_is_found_by_every_role() -> None:
    manager = built({"camera": Camera, "lidar": Lidar}, {"pilot": Pilot})
    camera = manager.nodes["camera"]
    for role in (manager, manager.handlers, manager.nodes["lidar"], manager.agents["pilot"]):
        assert role.node(Camera) is camera
        assert role.agent(Pilot) is manager.agents["pilot"]


def test_a_node_is_found_by_a_base_of_its_class() -> None:
    manager = built({"camera": DepthCamera, "lidar": Lidar})
    assert manager.node(Camera) is manager.nodes["camera"]


def test_of_several_nodes_of_a_class_the_name_chooses() -> None:
    manager = built({"front": Camera, "rear": DepthCamera})
    assert manager.node(Camera, "rear") is manager.nodes["rear"]
    assert manager.handlers.node(Camera, "front") is manager.nodes["front"]
    assert manager.node(DepthCamera) is manager.nodes["rear"]


def test_without_a_name_several_are_an_error_that_says_how_to_choose() -> None:
    manager = built({"front": Camera, "rear": Camera, "lidar": Lidar})
    assert refusal(lambda: manager.node(Camera)) == (
        "'front' and 'rear' are of class Camera; choose one, as in node(Camera, 'front')"
    )
    several = built({}, {"a": Pilot, "b": Pilot, "c": Pilot})
    assert refusal(lambda: several.handlers.agent(Pilot)) == (
        "'a', 'b' and 'c' are of class Pilot; choose one, as in agent(Pilot, 'a')"
    )


def test_a_class_that_is_not_registered_is_an_error_with_those_that_are() -> None:
    manager = built({"camera": Camera, "rear": DepthCamera})
    assert refusal(lambda: manager.node(Lidar)) == (
        "no node is of class Lidar; registered: 'camera' (Camera), 'rear' (DepthCamera)"
    )
    assert refusal(lambda: manager.agent(Pilot)) == (
        "no agent is of class Pilot; none is registered"
    )


def test_a_name_that_is_not_registered_or_of_another_class_is_an_error() -> None:
    manager = built({"camera": Camera, "lidar": Lidar})
    assert refusal(lambda: manager.node(Camera, "camra")) == (
        "no node is named 'camra';"
        " registered: 'camera' (Camera), 'lidar' (Lidar); did you mean camera?"
    )
    assert refusal(lambda: manager.node(Camera, "lidar")) == (
        "node 'lidar' is of class Lidar, not Camera"
    )


def test_a_component_without_a_manager_finds_none() -> None:
    assert refusal(lambda: BaseHandlers().node(Camera)) == (
        "no node is of class Camera; none is registered"
    )


def test_a_node_finds_in_its_constructor_those_before_it() -> None:
    class Tracker(BaseNode):
        def __init__(self, manager: Any = None, **kwargs: Any) -> None:
            super().__init__(manager, **kwargs)
            self.camera = self.node(Camera)

    manager = built({"camera": Camera, "tracker": Tracker})
    assert manager.node(Tracker).camera is manager.nodes["camera"]
    early = "no node is of class Camera; none is registered"
    assert refusal(lambda: built({"tracker": Tracker, "camera": Camera})) == early
