"""Parameters as a node declares, reads and sets them on the local backend."""

from collections.abc import Iterator
from typing import Any

import pytest

from rosbase import BaseNode, Parameter, ParameterError, ParameterSpec
from rosbase.testing import virtual_backend


@pytest.fixture
def node() -> Iterator[BaseNode]:
    node = BaseNode(backend=virtual_backend())
    yield node
    node.destroy_node()


def test_name_and_value_are_those_of_the_call_and_the_rest_those_of_the_spec(
    node: BaseNode,
) -> None:
    spec = ParameterSpec("something", 0.0, "m/s", minimum=0.0, maximum=2.0)
    assert node.declare_parameter("speed", 0.5, spec).value == 0.5
    assert not node.has_parameter("something")
    assert node.set_parameter("speed", 2.5).reason == "parameter speed is at most 2, not 2.5"
    with pytest.raises(ParameterError, match="parameter slow is at least 0, not -1"):
        node.declare_parameter("slow", -1.0, spec)


def test_a_list_that_is_changed_leaves_the_parameter_as_it_is(node: BaseNode) -> None:
    node.declare_parameter("gains", [1.0])
    node.get_parameter("gains").value.append("x")
    assert node.get_parameter("gains").value == [1.0]


@pytest.mark.parametrize("name", ["", None, 3])
def test_a_parameter_needs_a_name(node: BaseNode, name: Any) -> None:
    with pytest.raises(ParameterError, match="has a name of at least one character"):
        node.declare_parameter(name, 1)


def test_of_a_list_each_element_is_one_of_the_choices(node: BaseNode) -> None:
    spec = ParameterSpec("modes", ["a"], choices=("a", "b"))
    node.declare_parameter("modes", ["a"], spec)
    assert node.set_parameter("modes", ["b", "a"]).successful
    assert node.set_parameter("modes", ["b", "c"]).reason.startswith(
        "parameter modes is one of a, b"
    )


def test_a_callback_after_the_change_that_fails_is_said_and_ends_nothing(
    node: BaseNode, caplog: pytest.LogCaptureFixture
) -> None:
    told: list[Any] = []

    def fails(parameters: list[Parameter[Any]]) -> None:
        raise ValueError("no such gain")

    node.declare_parameter("gain", 1.0)
    node.add_post_set_parameters_callback(fails)
    node.add_post_set_parameters_callback(told.extend)
    assert node.set_parameter("gain", 2.0).successful
    node._backend.spin_once(0.0)
    assert told == [Parameter("gain", 2.0)]
    assert "fails raised ValueError: no such gain" in caplog.text
    assert [record.levelname for record in caplog.records] == ["ERROR"]


def test_a_component_is_asked_for_by_class(node: BaseNode) -> None:
    wrong: Any = "camera"
    with pytest.raises(TypeError, match=r"^node\(\) takes a class, and then perhaps a name"):
        node.node(wrong)
