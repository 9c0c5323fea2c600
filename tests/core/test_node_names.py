"""Names of nodes: refused on every backend if ROS would refuse them."""

from typing import Any

import pytest

from rosbase import (
    BackendError,
    BackendOptions,
    BaseManager,
    BaseNode,
    LifecycleNode,
    check_node_name,
    register_multiprocess_nodes,
)
from rosbase.local import LocalBackend
from rosbase.manager import BaseManager as Manager

WRONG = {
    "my-robot": "it has '-', and only letters, digits and _ are allowed; did you mean my_robot?",
    "a/b": "it has '/', and only letters, digits and _ are allowed; did you mean a_b?",
    "left arm": "did you mean left_arm?",
    "größe": "did you mean gr__e?",
    "1st": "it begins with a digit",
    "1-a": "it has '-', and only letters, digits and _ are allowed",
    "": "it is empty",
    "n" * 221: "it has 221 characters, and 220 are allowed",
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_name_is_one_line_that_says_why(name: str) -> None:
    with pytest.raises(BackendError) as caught:
        check_node_name(name)
    said = str(caught.value)
    assert "is not a node name: " in said
    assert WRONG[name] in said
    assert "\n" not in said
    assert len(said) < 200


def test_what_is_no_text_is_no_name() -> None:
    wrong: Any = 7
    with pytest.raises(BackendError, match="7 is not a node name: it is not text"):
        check_node_name(wrong)


@pytest.mark.parametrize("name", ["robot", "_private", "A1", "n" * 220])
def test_what_ros_takes_is_taken(name: str) -> None:
    check_node_name(name)


@pytest.mark.parametrize(
    "build",
    [
        lambda: BaseManager(node_name="my-robot", backend="local"),
        lambda: Manager("my-robot", backend="local"),
        lambda: BaseNode(node_name="my-robot", backend="local"),
        lambda: LifecycleNode(node_name="my-robot", backend="local"),
        lambda: LocalBackend(BackendOptions("my-robot")),
        lambda: register_multiprocess_nodes({"my-robot": BaseNode}),
    ],
)
def test_whatever_becomes_a_node_has_a_name_of_a_node(build: Any) -> None:
    with pytest.raises(BackendError, match="'my-robot' is not a node name"):
        build()
