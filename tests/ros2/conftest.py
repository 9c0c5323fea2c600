"""What the tests on real rclpy have in common."""

import sys
import warnings
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy

from rosbase.contracts.backend import BackendOptions
from rosbase_ros2.backend import Ros2Backend
from support.ros import Open, isolate, ros_context


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begins with the longest test: at the end, one worker would be busy with it alone."""
    items.sort(key=lambda item: item.path.name != "test_twins.py")


@pytest.fixture(scope="session", autouse=True)
def warm_ros(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Takes what rclpy takes once for the process, so that no test seems to leak it.

    The log file is open as long as there is a context, and DDS opens descriptors with the first
    participant that it never closes. One context therefore lives as long as the tests do. What a
    test opens itself is still found.
    """
    isolate(tmp_path_factory.mktemp("ros-log"))
    with ros_context() as context:
        with warnings.catch_warnings():
            # The first message imports a parser that imports what Python has deprecated.
            warnings.simplefilter("ignore", DeprecationWarning)
            node: Any = rclpy.create_node("warm_up", context=context)
        yield
        node.destroy_node()


@pytest.fixture
def context(warm_ros: None) -> Iterator[Any]:
    """A context for one test."""
    with ros_context() as context:
        yield context


@pytest.fixture
def backend() -> Iterator[Ros2Backend]:
    """A backend for one test, that of a node called `test_node`."""
    backend = Ros2Backend(BackendOptions("test_node"))
    yield backend
    backend.close()


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> Iterator[Open]:
    """Opens backends with arguments for ROS; the node is called `driver`."""
    backends: list[Ros2Backend] = []

    def open_one(*arguments: str, **options: Any) -> Ros2Backend:
        monkeypatch.setattr(sys, "argv", ["program", "--ros-args", *arguments])
        backends.append(Ros2Backend(BackendOptions("driver", **options)))
        return backends[-1]

    yield open_one
    for backend in backends:
        backend.close()
