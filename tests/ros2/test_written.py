"""Values count as they are written, by the declared type, not as YAML guesses."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from hypothesis import example, given, settings
from hypothesis import strategies as st
from rclpy.signals import SignalHandlerOptions

from rosbase import BackendError, ParameterError, ParameterSpec, WrittenText
from rosbase_ros2.given import given_parameters
from rosbase_ros2.written import RosArguments, is_guess_of
from support.ros import Open, params_file
from support.strategies import yaml_scalars

TEXT = ParameterSpec("text", "a")
PATHS = ParameterSpec("paths", ["a"])
RATE = ParameterSpec("rate", 1.0)
COUNT = ParameterSpec("count", 1)
FLAG = ParameterSpec("flag", default=False)
MODE = ParameterSpec("mode", "warn", choices=("warn", "reject", "off"))
VERSION = ParameterSpec("version", "3.1.1", choices=("3.1.1", "5"))
GAINS = ParameterSpec("gains", [1.0])
IDS = ParameterSpec("ids", [1])
FLAGS = ParameterSpec("flags", [True])
KEY = ParameterSpec("key", [b"a"])

TAKEN: list[tuple[ParameterSpec, str, Any]] = [
    (MODE, "off", "off"),
    (VERSION, "5", "5"),
    (TEXT, "no", "no"),
    (TEXT, "0042", "0042"),
    (TEXT, "1e3", "1e3"),
    (TEXT, "0x1F", "0x1F"),
    (TEXT, "007.50", "007.50"),
    (TEXT, "nan", "nan"),
    (TEXT, "~", "~"),
    (TEXT, "12:30", "12:30"),
    (TEXT, "'0042'", "0042"),
    (TEXT, '"off"', "off"),
    (PATHS, "[]", []),
    (PATHS, "[x, y, z]", ["x", "y", "z"]),
    (PATHS, "[y, n]", ["y", "n"]),
    (PATHS, "[1, 'b, c', 2.50]", ["1", "b, c", "2.50"]),
    (PATHS, "y", ["y"]),
    (PATHS, "'x, y'", ["x", "y"]),
    (RATE, "5", 5.0),
    (RATE, "1e3", 1000.0),
    (COUNT, "0x10", 16),
    (FLAG, "on", True),
    (FLAG, "N", False),
    (GAINS, "[0, 2.5]", [0.0, 2.5]),
    (GAINS, "[]", []),
    (GAINS, "3", [3.0]),
    (IDS, "[]", []),
    (IDS, "[7, 0x0a]", [7, 10]),
    (FLAGS, "[]", []),
    (FLAGS, "[on, false]", [True, False]),
    (KEY, "[]", []),
    (KEY, "[0, 0xff]", [b"\x00", b"\xff"]),
]
# Only on a command line: in a file rcl refuses them, and says where they stand.
RULES: list[tuple[ParameterSpec, str, Any]] = [
    (TEXT, "", ""),
    (TEXT, "#", "#"),
    (TEXT, "@home", "@home"),
    (TEXT, "*", "*"),
    (TEXT, "-", "-"),
    (TEXT, "{a: 1}", "{a: 1}"),
    (TEXT, "a: b", "a: b"),
    (TEXT, 'say "%s"', 'say "%s"'),
    (PATHS, "[0].x", ["[0].x"]),
    (PATHS, "[[0].x, [1].x]", ["[0].x", "[1].x"]),
    (PATHS, "", []),
]
REFUSED = [
    (COUNT, "0042", "parameter count: 0042 is octal in YAML; write 42, if it is meant"),
    (RATE, "0042", "parameter rate: 0042 is octal in YAML; write 42, if it is meant"),
    (COUNT, "'5'", "parameter count takes a whole number, not '5'"),
    (COUNT, "5.0", "parameter count takes a whole number, not 5.0"),
    (RATE, "fast", "parameter rate takes a number, not 'fast'"),
    (FLAG, "1", "parameter flag takes true or false, not 1"),
    (TEXT, "[a]", "parameter text takes text, not ['a']"),
    (TEXT, "[]", "parameter text takes text, not []"),
    (IDS, "[1, 2.5]", "parameter ids takes whole numbers such as [1, 2], not [1, 2.5]"),
    (IDS, "['1', 2]", "parameter ids takes whole numbers such as [1, 2], not ['1', 2]"),
    (KEY, "[256]", "parameter key takes bytes such as [0, 255], not [256]"),
    (MODE, "Off", "parameter mode is one of warn, reject, off, not 'Off'"),
]


def declared(backend: Any, spec: ParameterSpec) -> Any:
    value = backend.declare_parameter(spec).value
    assert backend.get_parameter(spec.name).value == value
    return value


@pytest.mark.parametrize(("spec", "text", "expected"), TAKEN + RULES)
def test_a_rule_says_a_value_of_the_declared_type(
    opened: Open, spec: ParameterSpec, text: str, expected: Any
) -> None:
    value = declared(opened("-p", f"{spec.name}:={text}"), spec)
    assert (value, type(value)) == (expected, type(expected))


@pytest.mark.parametrize(("spec", "text", "expected"), TAKEN)
def test_a_file_says_a_value_of_the_declared_type(
    opened: Open, tmp_path: Path, spec: ParameterSpec, text: str, expected: Any
) -> None:
    file = params_file(tmp_path, f"driver:\n  ros__parameters:\n    {spec.name}: {text}\n")
    value = declared(opened("--params-file", file), spec)
    assert (value, type(value)) == (expected, type(expected))


@pytest.mark.parametrize(("spec", "text", "said"), REFUSED)
@pytest.mark.parametrize("is_file", [False, True])
def test_what_is_no_value_is_one_line(
    opened: Open, tmp_path: Path, spec: ParameterSpec, text: str, said: str, is_file: bool
) -> None:
    file = params_file(tmp_path, f"/**:\n  ros__parameters:\n    {spec.name}: {text}\n")
    given = ("--params-file", file) if is_file else ("-p", f"{spec.name}:={text}")
    backend = opened(*given)
    with pytest.raises(ParameterError) as caught:
        backend.declare_parameter(spec)
    assert str(caught.value).startswith(said)
    assert "\n" not in str(caught.value)
    with pytest.raises(ParameterError, match="not been declared"):
        backend.get_parameter(spec.name)


def test_block_lists_and_nested_names_are_taken(opened: Open, tmp_path: Path) -> None:
    file = params_file(
        tmp_path,
        "driver:\n  ros__parameters:\n    mapping:\n      acceleration:\n        paths:\n"
        "        - x  # forward\n        - y\n        - -z\n      mode: off\n    text: >-\n"
        "      0042\n",
    )
    backend = opened("--params-file", file)
    assert declared(backend, ParameterSpec("mapping.acceleration.paths", ["a"])) == ["x", "y", "-z"]
    assert declared(backend, ParameterSpec("mapping.mode", "warn")) == "off"
    assert declared(backend, TEXT) == "0042"


def test_the_last_one_counts_also_where_yaml_guesses_two_types(
    opened: Open, tmp_path: Path
) -> None:
    # rcl itself keeps the truth, and the list that is not empty.
    file = params_file(tmp_path, "/**:\n  ros__parameters: {mode: off, paths: [a], text: 7}\n")
    backend = opened("--params-file", file, "-p", "mode:=warn", "-p", "paths:=[]")
    assert declared(backend, MODE) == "warn"
    assert declared(backend, PATHS) == []
    assert declared(backend, TEXT) == "7"


def test_a_pipe_is_a_file_too(opened: Open) -> None:
    reading, writing = os.pipe()

    def write() -> None:
        with open(writing, "w") as file:
            file.write("driver:\n  ros__parameters: {text: no, paths: [x, y]}\n")

    thread = threading.Thread(target=write)
    thread.start()
    backend = opened("--params-file", f"/proc/self/fd/{reading}")
    thread.join()
    os.close(reading)
    assert declared(backend, TEXT) == "no"
    assert declared(backend, PATHS) == ["x", "y"]


def test_what_rcl_says_of_a_file_names_the_user_s(opened: Open, tmp_path: Path) -> None:
    file = params_file(tmp_path, "driver:\n  ros__parameters:\n    paths: [x, y]\n    text:\n")
    with pytest.raises(BackendError, match="No value at line 4") as caught:
        opened("--params-file", file)
    assert file in str(caught.value)
    assert "/proc" not in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "driver: &a\n  ros__parameters: *a\n",
        "driver:\n  ros__parameters:\n    a: &a {x: 1}\n    b: *a\n",
        "driver:\n  ros__parameters: {a: &a {x: 1}, b: &b [*a, *a], c: [*b, *b]}\n",
    ],
)
def test_aliases_are_left_to_rcl_which_refuses_them(
    opened: Open, tmp_path: Path, text: str
) -> None:
    with pytest.raises(BackendError, match=r"(?i)alias") as caught:
        opened("--params-file", params_file(tmp_path, text))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["", "# nothing\n", "5\n", "\ufeff# nothing\n"])
def test_a_file_without_parameters_changes_nothing(opened: Open, tmp_path: Path, text: str) -> None:
    assert declared(opened("--params-file", params_file(tmp_path, text)), TEXT) == "a"


@pytest.mark.parametrize(
    "text", ["---\n", "- a\n", "a: {b: }\n", "a: [b\n", "driver:\n\trate: 1\n", "? [a]\n"]
)
def test_a_file_that_is_none_is_refused_by_rcl(opened: Open, tmp_path: Path, text: str) -> None:
    file = params_file(tmp_path, text)
    with pytest.raises(BackendError, match="ROS 2 does not start") as caught:
        opened("--params-file", file)
    assert file in str(caught.value)
    assert "\n" not in str(caught.value)


def test_lines_that_end_as_on_windows_are_taken(opened: Open, tmp_path: Path) -> None:
    file = tmp_path / "params.yaml"
    file.write_bytes(b"driver:\r\n  ros__parameters:\r\n    paths: [x, y]\r\n    text: no\r\n")
    backend = opened("--params-file", str(file))
    assert declared(backend, PATHS) == ["x", "y"]
    assert declared(backend, TEXT) == "no"


def test_a_file_of_launch_has_lost_how_values_were_written(opened: Open, tmp_path: Path) -> None:
    # launch reads `no` and `0042` as YAML, and writes what it has guessed.
    file = tmp_path / "launch_params_x1"
    file.write_text(
        "/**:\n  ros__parameters:\n    mode: false\n    version: 5\n    text: 34\n"
        "    flag: false\n    rate: 2\n    paths: [x, y]\n    other: 1e3\n"
    )
    backend = opened("--params-file", str(file))
    assert declared(backend, MODE) == "off"
    assert declared(backend, VERSION) == "5"
    assert declared(backend, FLAG) is False
    assert declared(backend, RATE) == 2.0
    assert declared(backend, PATHS) == ["x", "y"]
    assert declared(backend, ParameterSpec("other", "")) == "1e3"
    with pytest.raises(ParameterError, match="text takes text, not 34; write text in quotes"):
        backend.declare_parameter(TEXT)


def test_a_program_s_own_overrides_win(opened: Open) -> None:
    backend = opened("-p", "text:=no", parameter_overrides={"text": "mine", "ids": []})
    assert declared(backend, TEXT) == "mine"
    assert declared(backend, IDS) == []


# rcl and rclpy, asked the same.


@contextmanager
def asked(arguments: list[str], namespace: str | None = None) -> Iterator[dict[str, Any]]:
    """What rclpy makes of arguments that rcl takes."""
    context: Any = rclpy.Context()
    quiet = SignalHandlerOptions.NO
    rclpy.init(args=["--ros-args", *arguments], context=context, signal_handler_options=quiet)
    try:
        node = rclpy.create_node("driver", context=context, namespace=namespace)
        yield given_parameters(node)
        node.destroy_node()
    finally:
        context.try_shutdown()
        context.destroy()


@settings(max_examples=20, deadline=None)
@given(st.lists(yaml_scalars, min_size=10, max_size=30))
@example(["0", "-0", "08", "0x", "0x1p-3", "1e999", "-.inf", "+.INF", ".Nan", "1e", "infinity"])
@example(["9223372036854775807", "9223372036854775808", "-9223372036854775808", "00", "yEs", "."])
@example(
    [
        "+",
        "-",
        "1_0",
        "0b1",
        "0o7",
        "1.",
        ".e1",
        "+.5",
        "0x.8",
        "0x1.",
        "- 1",
        "0X1P3",
        "NaN",
        "-nan",
    ]
)
def test_what_rcl_guesses_is_known(warm_ros: None, texts: list[str]) -> None:
    rules = [word for n, text in enumerate(texts) for word in ("-p", f"p{n}:={text}")]
    arguments = RosArguments(rules)
    written = arguments.written_for("/driver")
    with arguments.for_rcl() as taken, asked(taken) as found:
        for name, value in found.items():
            (text,) = written[name]
            assert text is not None
            assert is_guess_of(value, text), (value, text)


SECTIONS = [
    *("driver", "/driver", "/**", "'/*'", "'**'", "'*'", "robot/driver", "/robot/driver", "/robot"),
    *("/robot/*", "/*/driver", "/**/driver", "/robot/**", "/*/*", "/**/*", "other", "/robot/other"),
]


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from(SECTIONS), st.sampled_from("pqr")), min_size=1, max_size=8),
    st.sampled_from([None, "/robot", "/robot/left"]),
)
def test_the_sections_that_apply_are_those_of_rclpy(
    warm_ros: None,
    tmp_path_factory: pytest.TempPathFactory,
    entries: list[tuple[str, str]],
    namespace: str | None,
) -> None:
    files: list[str] = []
    for number, (section, name) in enumerate(entries):
        text = f"{section}:\n  ros__parameters: {{{name}: v{number}}}\n"
        files += ["--params-file", params_file(tmp_path_factory.mktemp("params"), text)]
    half = len(entries) // 2 * 2
    arguments = [*files[:half], "-p", "q:=rule", "-p", "driver:r:=rule", *files[half:]]
    with asked(arguments, namespace) as found:
        written = RosArguments(arguments).written_for(f"{namespace or ''}/driver")
    assert {name: texts[-1] for name, texts in written.items()} == {
        name: WrittenText(value) for name, value in found.items()
    }
