"""Message classes of a third party, which a plugin converts."""

import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from geometry_msgs.msg import Vector3 as RosVector3
from geometry_msgs.msg import Wrench, WrenchStamped
from rclpy.executors import SingleThreadedExecutor

from rosbase.contracts.backend import BackendOptions
from rosbase.errors import PluginError
from rosbase.messages import Header, Vector3
from rosbase.plugins import installed_plugins
from rosbase_ros2.backend import Ros2Backend
from support.plugins import CONVERSION_PLUGIN, install_plugin
from support.waiting import wait_until

FROM_THE_FIELDS = "from geometry_msgs.msg import Wrench; return Wrench"
BY_HAND = """from geometry_msgs.msg import Vector3 as RosVector3, Wrench
    from rosbase_ros2.conversion import Converter
    to_ros = lambda mine: Wrench(force=RosVector3(x=2.0 * mine.force.x))
    from_ros = lambda ros: Force(Vector3(ros.force.x / 2.0), Vector3())
    return Converter(Force, Wrench, to_ros, from_ros)"""


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., type]]:
    """Installs a plugin by what its `create` does; gives its class of messages."""
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.syspath_prepend(tmp_path)
    before = set(sys.modules)

    def install(create: str, distribution: str = "arm", msg_type: str = "Force") -> Any:
        code = CONVERSION_PLUGIN.format(create=create, msg_type=msg_type)
        install_plugin(tmp_path, distribution, "force", code)
        installed_plugins.cache_clear()
        installed_plugins()
        return sys.modules["arm_force"].Force

    yield install
    installed_plugins.cache_clear()
    for name in set(sys.modules) - before:
        del sys.modules[name]


@pytest.fixture
def backend() -> Iterator[Ros2Backend]:
    backend = Ros2Backend(BackendOptions("arm"))
    yield backend
    backend.close()


@pytest.mark.parametrize(("create", "factor"), [(FROM_THE_FIELDS, 1.0), (BY_HAND, 2.0)])
def test_messages_of_a_third_party_go_to_plain_rclpy_and_come_back(
    install: Callable[..., Any], backend: Ros2Backend, context: Any, create: str, factor: float
) -> None:
    force = install(create)
    node: Any = rclpy.create_node("plain", context=context)
    executor: Any = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    there: list[Any] = []
    here: list[Any] = []
    node.create_subscription(Wrench, "push", there.append, 10)
    by_hand = node.create_publisher(Wrench, "pull", 10)
    publisher = backend.create_publisher(force, "push", 10)
    backend.create_subscription(force, "pull", here.append, 10)

    def went_both_ways() -> bool:
        publisher.publish(force(Vector3(1.5), Vector3()))
        by_hand.publish(Wrench(force=RosVector3(x=3.0 * factor)))
        executor.spin_once(timeout_sec=0.01)
        backend.spin_once(0.01)
        return bool(here and there)

    wait_until(went_both_ways, "a message each way")
    executor.shutdown()
    node.destroy_node()
    assert there[0] == Wrench(force=RosVector3(x=1.5 * factor))
    assert here[0] == force(Vector3(3.0), Vector3())


STAMPED = """
import attrs
from arm_force import Force
from rosbase.messages import Header
from rosbase.plugins import ConversionPlugin, hookimpl

@attrs.frozen
class Stamped:
    header: Header
    wrench: Force

def create():
    from geometry_msgs.msg import WrenchStamped
    return WrenchStamped

@hookimpl
def rosbase_conversions():
    yield ConversionPlugin(Stamped, "ros2", "geometry_msgs/WrenchStamped", create)
"""


def test_a_class_of_a_third_party_is_converted_inside_that_of_another(
    install: Callable[..., Any], backend: Ros2Backend, tmp_path: Path
) -> None:
    install_plugin(tmp_path, "leg", "stamped", STAMPED)
    force = install(BY_HAND)
    stamped = sys.modules["leg_stamped"].Stamped
    got: list[Any] = []
    publisher = backend.create_publisher(stamped, "stamped", 10)
    backend.create_subscription(WrenchStamped, "stamped", got.append, 10)

    def arrived() -> bool:
        publisher.publish(stamped(Header(frame_id="wrist"), force(Vector3(1.5), Vector3())))
        return bool(backend.spin_once(0.01) and got)

    wait_until(arrived, "the message")
    assert (got[0].header.frame_id, got[0].wrench.force.x) == ("wrist", 3.0)


@pytest.mark.parametrize(
    ("create", "reason"),
    [
        ("raise OSError('no\\nluck')", "OSError: no luck"),
        ("return 5", "TypeError: 5 is neither a ROS message class nor a Converter for this one"),
        (
            "from geometry_msgs.msg import Twist; return Twist",
            "TypeError: Force and Twist of ROS differ in fields: angular, force, linear, torque",
        ),
    ],
)
def test_a_conversion_that_is_of_no_use_is_one_line_that_names_the_plugin(
    install: Callable[..., Any], backend: Ros2Backend, create: str, reason: str
) -> None:
    force = install(create)
    line = f"conversion 'arm_force.Force on ros2' cannot be used: arm:force failed: {reason}"
    for make in (
        lambda: backend.create_publisher(force, "push", 10),
        lambda: backend.create_subscription(force, "push", print, 10),
    ):
        with pytest.raises(PluginError) as caught:
            make()
        assert str(caught.value) == line


def test_a_class_that_two_plugins_convert_is_refused_and_both_are_named(
    install: Callable[..., Any], backend: Ros2Backend
) -> None:
    force = install(FROM_THE_FIELDS)
    install(FROM_THE_FIELDS, "leg", "__import__('arm_force').Force")
    with pytest.raises(PluginError, match="is claimed by arm:force and leg:force"):
        backend.create_publisher(force, "push", 10)
