"""Values that are given to a node of the local backend from outside."""

import pytest

from rosbase import BackendOptions, BaseNode, ParameterError
from rosbase.local import Bus, LocalBackend
from rosbase.parameters import ParameterValue
from rosbase.testing import ManualClock, virtual_backend


def spin(backend: LocalBackend) -> None:
    while backend.spin_once(0.0):
        pass


def test_one_that_no_node_declares_is_named_once_with_the_nearest_one(
    caplog: pytest.LogCaptureFixture,
) -> None:
    overrides: dict[str, ParameterValue] = {"stale_timout": 3.0, "rate": 7, "robot.name": "eve"}
    backend = LocalBackend(BackendOptions("driver", overrides, ManualClock()), Bus())
    node = BaseNode(backend=backend)
    node.declare_parameter("stale_timeout", 1.0)
    assert node.declare_parameter("rate", 1.0).value == 7.0
    for _ in range(3):
        spin(backend)
    said = "is set from outside, but this node does not declare it"
    assert [record.getMessage() for record in caplog.records] == [
        f"parameter robot.name {said}",
        f"parameter stale_timout {said}; did you mean stale_timeout?",
    ]
    backend.close()


def test_nothing_is_said_where_everything_is_declared(caplog: pytest.LogCaptureFixture) -> None:
    backend = virtual_backend(gains=[1, 2.5], ids=[], key=[7])
    node = BaseNode(backend=backend)
    assert node.declare_parameter("gains", [1.0]).value == [1.0, 2.5]
    assert node.declare_parameter("ids", [1]).value == []
    assert node.declare_parameter("key", [b"a"]).value == [b"\7"]
    spin(backend)
    assert caplog.records == []
    backend.close()


def test_a_list_that_is_empty_and_has_no_kind_is_one_line() -> None:
    backend = virtual_backend()
    with pytest.raises(TypeError, match="parameter gains: say which kind of array it is"):
        BaseNode(backend=backend).declare_parameter("gains", [])
    with pytest.raises(ParameterError, match="has not been declared"):
        backend.get_parameter("gains")
    backend.close()
