"""What `ros2 param dump` and `ros2 param set` do with a node of rosbase."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterType
from rclpy.parameter import parameter_value_to_python

from imu_serial.simulator import PtyDevice
from rosbase import BackendOptions, ParameterKind, ParameterSpec
from rosbase_ros2.backend import Ros2Backend
from support.command import RunningRosbase
from support.ros import Client, Open, ParameterTool, params_file
from support.strategies import texts, yaml_scalars
from support.waiting import wait_until

AWKWARD = ["", "off", "y", "NO", "0042", "089", "1e3", "12:30", "~", "null", ".inf", "0x1F", "#"]
VALUES: dict[ParameterKind, list[Any]] = {
    ParameterKind.BOOL: [True, False],
    ParameterKind.INTEGER: [0, -7, 2**63 - 1],
    ParameterKind.DOUBLE: [2.0, -1e-7, 1e300, 0.1],
    ParameterKind.STRING: [*AWKWARD, "two\nlines\n", " x ", "größe", "x" * 200 + " " + "y" * 100],
    ParameterKind.BYTE_ARRAY: [[], [b"\x00", b"\xff", b"a"]],
    ParameterKind.BOOL_ARRAY: [[], [True, False]],
    ParameterKind.INTEGER_ARRAY: [[], [1, -2]],
    ParameterKind.DOUBLE_ARRAY: [[], [1.0, 2.0], [0.5]],
    ParameterKind.STRING_ARRAY: [[], ["a"], ["x", "y", "z"], AWKWARD],
}
DEFAULTS: dict[ParameterKind, Any] = {
    ParameterKind.BOOL: False,
    ParameterKind.INTEGER: 5,
    ParameterKind.DOUBLE: 5.5,
    ParameterKind.STRING: "default",
}


@contextmanager
def tool(context: Any, server: str) -> Iterator[ParameterTool]:
    made = ParameterTool(context, server)
    try:
        yield made
    finally:
        made.destroy()


def spec_of(name: str, kind: ParameterKind, value: Any) -> ParameterSpec:
    return ParameterSpec(name, value, kind=kind)


def test_what_is_dumped_can_be_loaded(opened: Open, context: Any, tmp_path: Path) -> None:
    given = {
        f"group{number % 3}.{kind.name.lower()}.v{number}": (kind, value)
        for kind, values in VALUES.items()
        for number, value in enumerate(values)
    }
    first = opened()
    for name, (kind, value) in given.items():
        first.declare_parameter(spec_of(name, kind, value))
    with tool(context, "driver") as param:
        dumped = param.dump()
    first.close()
    second = opened("--params-file", params_file(tmp_path, dumped))
    found = {}
    for name, (kind, _) in given.items():
        declared = second.declare_parameter(spec_of(name, kind, DEFAULTS.get(kind, [])))
        found[name] = (kind, declared.value)
    assert found == given
    with tool(context, "driver") as param:
        assert param.dump() == dumped


@settings(max_examples=15, deadline=None)
@given(st.lists(texts | yaml_scalars, min_size=3, max_size=20))
@example(["y", "n", "~", "=", "<<", "!", "&a", "*a", "- a", "a: b", "%", "@", "`", "?", "|", ">"])
def test_every_text_survives_a_dump(
    warm_ros: None, tmp_path_factory: pytest.TempPathFactory, found: list[str]
) -> None:
    parameters: dict[str, Any] = {f"t{n}": text for n, text in enumerate(found)}
    tree = {"/driver": {"ros__parameters": {"all": found, **parameters}}}
    dumped = yaml.dump(tree, default_flow_style=False)
    file = params_file(tmp_path_factory.mktemp("dump"), dumped)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["program", "--ros-args", "--params-file", file])
        backend = Ros2Backend(BackendOptions("driver"))
    try:
        read = [backend.declare_parameter(ParameterSpec(name, "")).value for name in parameters]
        spec = ParameterSpec("all", [], kind=ParameterKind.STRING_ARRAY)
        assert read == backend.declare_parameter(spec).value == found
    finally:
        backend.close()


# The reader.


@pytest.fixture
def device() -> Iterator[PtyDevice]:
    device = PtyDevice()
    yield device
    device.close()


@contextmanager
def reader_with(context: Any, *arguments: str) -> Iterator[ParameterTool]:
    """A reader that others drive, and the tool at its parameters."""
    with RunningRosbase("imu", "--backend", "ros2", "--managed", "--ros-args", *arguments) as run:
        with tool(context, "lifecycle_manager") as param:
            # The services are there before the parameters are, and before the main loop runs.
            wait_until(lambda: param.set("orientation_stddev", "[]").successful, "the main loop")
            # From the first parameter on, none is set that the reader has not judged.
            assert not param.set("preset", "no such preset").successful
            yield param
        assert run.end(2) == 0
    assert not any("Traceback" in line for line in run.err.lines)


def test_the_dump_of_a_reader_gives_the_same_reader(
    device: PtyDevice, context: Any, tmp_path: Path
) -> None:
    path = device.parameters["device_path"]
    arguments = [
        *("-p", f"device_path:={path}", "-p", "plausibility:=off", "-p", "dtr:=off"),
        *(
            "-p",
            "mqtt_version:=5",
            "-p",
            "frame_id:=no",
            "-p",
            "mapping.orientation.paths:=[]",
            "-p",
            "stale_timeout:=2",
        ),
        *("-p", "mapping.linear_acceleration.paths:=[x, y, z]"),
        *("-p", "mapping.linear_acceleration.unit:=m/s^2", "-p", "mapping.required:=[]"),
    ]
    with reader_with(context, *arguments) as param:
        dumped = param.dump()
    assert "        paths: []" in dumped
    file = params_file(tmp_path, dumped)
    with reader_with(context, "--params-file", file) as param:
        assert param.dump() == dumped
        names = ("plausibility", "dtr", "frame_id", "stale_timeout")
        values = [parameter_value_to_python(value) for value in param.get(*names)]
        assert values == ["off", "off", "no", 2.0]
        (paths,) = param.get("mapping.linear_acceleration.paths")
        assert list(paths.string_array_value) == ["x", "y", "z"]


def test_setting_a_parameter_of_a_reader_tells_the_truth(device: PtyDevice, context: Any) -> None:
    client = Client(context, "lifecycle_manager")
    path = device.parameters["device_path"]

    def refusal(name: str, text: str) -> str:
        result = param.set(name, text)
        return "" if result.successful else str(result.reason)

    try:
        with reader_with(context, "-p", f"device_path:={path}") as param:
            client.await_services()
            # Unconfigured: everything that can be.
            assert refusal("stale_timeout", "2") == ""
            assert refusal("plausibility", "off") == ""
            assert refusal("mapping.select", "[]") == ""
            assert refusal("mapping.linear_acceleration.unit", "g") == ""
            assert refusal("mapping.linear_acceleration.paths", "[ax, no, az]") == ""
            (paths,) = param.get("mapping.linear_acceleration.paths")
            assert list(paths.string_array_value) == ["ax", "no", "az"]
            assert refusal("baudrate", "9600") == ""
            assert refusal("baudrate", "115200") == ""
            assert "write text in quotes" in refusal("frame_id", "0042")
            assert refusal("frame_id", "'0042'") == ""
            assert "did you mean" in refusal("preset", "mpu605")
            assert "read-only" in refusal("autostart", "activate")
            assert "takes a whole number" in refusal("baudrate", "fast")
            kinds = [value.type for value in param.get("stale_timeout", "mapping.select")]
            assert kinds == [
                ParameterType.PARAMETER_DOUBLE,
                ParameterType.PARAMETER_STRING_ARRAY,
            ]
            assert client.change(label="configure")
            assert "set it while unconfigured" in refusal("device_path", "/dev/ttyUSB7")
            assert refusal("plausibility", "warn") == ""
            assert client.change(label="activate")
            assert "set it while unconfigured" in refusal("topic_namespace", "left")
            assert "set it while inactive or unconfigured" in refusal("plausibility", "reject")
            assert refusal("frame_id", "left") == ""
            (frame_id,) = param.get("frame_id")
            assert frame_id.string_value == "left"
    finally:
        client.destroy()
