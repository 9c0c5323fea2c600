"""What importing messages costs, and where they are."""

import subprocess
import sys
from importlib import import_module
from importlib.util import find_spec

import pytest

import rosbase
from rosbase import messages, wire
from rosbase.messages.fields import ros_type
from support.wire_messages import CLASSES, name_of


def modules_of(program: str) -> set[str]:
    """The modules of rosbase that a program imports, and numpy and pickle if it does."""
    program += (
        "\nimport sys"
        "\nprint(*(n for n in sys.modules if n.startswith(('rosbase', 'numpy', 'pickle'))))"
    )
    command = [sys.executable, "-W", "error", "-c", program]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    return set(done.stdout.split())


def packages_in(modules: set[str]) -> set[str]:
    return {name.split(".")[2] for name in modules if name.count(".") == 2 and "_msgs" in name}


def test_messages_that_are_not_used_are_not_imported() -> None:
    nothing = modules_of("import rosbase.messages; dir(rosbase.messages)")
    assert packages_in(nothing) == set()
    header = modules_of("from rosbase.messages import Header")
    assert packages_in(header) == {"std_msgs"}
    imu = modules_of("from rosbase.messages import Imu; Imu()")
    assert packages_in(imu) == {"std_msgs", "geometry_msgs", "sensor_msgs"}
    assert "rosbase.messages.sensor_msgs._point_cloud2" not in imu
    image = modules_of("from rosbase.messages import Image; Image()")
    for modules in (nothing, header, imu, image):
        unused = ("numpy", "pickle", "rosbase.wire")
        assert not [name for name in modules if name.startswith(unused)]


def test_a_program_that_uses_no_message_imports_no_wire() -> None:
    modules = modules_of("from rosbase import BaseManager, BaseNode; BaseNode(backend='local')")
    assert packages_in(modules) == set()
    assert not [name for name in modules if name.startswith(("numpy", "rosbase.wire"))]


def test_a_program_without_services_imports_no_client_of_services() -> None:
    modules = modules_of("from rosbase import BaseManager; BaseManager(backend='local')")
    assert not [name for name in modules if name.endswith(("service_client", "service_callback"))]


def test_a_prepared_sender_imports_no_writer_and_no_hashes() -> None:
    modules = modules_of(
        "from rosbase.contracts.backend import BackendOptions\n"
        "from rosbase.local import LocalBackend\n"
        "from rosbase.messages import Imu\n"
        "backend = LocalBackend(BackendOptions('test'))\n"
        "publisher = backend.create_publisher(Imu, 'imu', 1)\n"
        "backend.prepared_sender(publisher, Imu(), ['orientation'])((0.0, 0.0, 0.0, 1.0))\n"
        "backend.close()"
    )
    imported = {name.rpartition(".")[2] for name in modules if name.startswith("rosbase.wire.")}
    assert imported == {
        *("description", "filling", "making", "once", "source", "structure", "varying")
    }


def test_every_public_name_of_the_wire_is_there_and_no_module_hides_it() -> None:
    for name in wire.__all__:
        assert find_spec(f"rosbase.wire.{name}") is None
        assert callable(getattr(wire, name))
    assert dir(wire) == sorted(wire.__all__)


@pytest.mark.parametrize("cls", CLASSES, ids=name_of)
def test_a_message_is_in_the_module_of_its_ros_package(cls: type) -> None:
    package, _, name = name_of(cls).split("/")
    module = import_module(f"rosbase.messages.{package}")
    assert getattr(module, name) is cls
    assert name in dir(module)
    assert (cls.__module__, cls.__qualname__) == (module.__name__, name)


def test_every_public_name_of_the_messages_is_there_and_no_other() -> None:
    for name in messages.__all__:
        assert getattr(messages, name) is not None
    assert dir(messages) == sorted(messages.__all__)
    for module in (messages, wire, import_module("rosbase.messages.sensor_msgs")):
        with pytest.raises(AttributeError, match=r"has no attribute 'Nothing'$"):
            module.Nothing  # noqa: B018 - the access is the test


def test_the_decorator_and_the_error_are_names_of_rosbase() -> None:
    from rosbase.errors import WireError
    from rosbase.messages.fields import message

    assert rosbase.message is message
    assert rosbase.WireError is WireError


def test_a_service_has_the_classes_of_its_request_and_its_response() -> None:
    from rosbase.messages.std_srvs import SetBool, SetBool_Request, SetBool_Response

    assert SetBool.Request is SetBool_Request
    assert SetBool.Response is SetBool_Response
    assert ros_type(SetBool.Request) == "std_srvs/srv/SetBool_Request"
