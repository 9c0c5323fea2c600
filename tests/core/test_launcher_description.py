"""Files of the launcher: what they mean, and every mistake in them by its line."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase import ConfigurationError
from rosbase.launcher.description import Condition, Description, Faults, read_mapping, read_text
from rosbase.launcher.description.cpus import read_cpus
from rosbase.launcher.description.order import circles, in_order
from rosbase.launcher.description.toml_lines import lines_of
from rosbase.launcher.selection import choose
from rosbase.parameters.given import GivenValue
from rosbase.processes import RestartPolicy
from rosbase.text.toml import parse_toml
from support.strategies import launcher_data, program_names, waiting_programs

HERE = Path("/work place")


def read(config: Mapping[str, Any]) -> tuple[Description, list[str]]:
    faults = Faults()
    description = read_mapping(config, HERE, faults)
    return description, [str(fault) for fault in faults.in_order()]


def faults_of(toml: str) -> list[str]:
    """The mistakes in the text of a file that is called `robot.toml`."""
    faults = Faults("robot.toml")
    read_text(toml, HERE / "robot.toml", faults)
    return [str(fault) for fault in faults.in_order()]


def program(**keys: Any) -> tuple[Any, list[str]]:
    """A program with these keys, beside one that is called `other`."""
    nodes = [{"name": "robot", "command": "run", **keys}, {"name": "other", "command": "run"}]
    description, faults = read({"nodes": nodes})
    return next(description.programs), faults


def test_a_session_at_the_root_is_a_list_of_one() -> None:
    session = {"env": {"session_name": "demo"}, "nodes": [{"name": "a", "command": "x"}]}
    assert read(session) == read({"sessions": [session]})
    description, faults = read(session)
    assert not faults
    assert [one.name for one in description.sessions] == ["demo"]


def test_all_that_ros_base_knows_is_read() -> None:
    description, faults = read(
        {
            "env": {
                "session_name": "demo_system",
                "workspace_root": "/robots",
                "ros_setup": "/ros_ws/setup.sh",
                "conda_env": "robot",
            },
            "nodes": [
                {
                    "name": "LOW_LEVEL",
                    "project": "controller/a",
                    "cpus": "0,2",
                    "autostart": False,
                    "command": ["make", "python run.py"],
                },
                {"name": "HIGH", "project": ".", "command": "python run.py"},
            ],
        }
    )
    assert not faults
    session = description.sessions[0]
    assert (session.ros_setup, session.conda_env) == (Path("/ros_ws/setup.sh"), "robot")
    low, high = session.programs
    assert (low.folder, low.cpus) == (Path("/robots/controller/a"), (0, 2))
    assert (low.autostart, low.commands) == (False, ("make", "python run.py"))
    assert (high.folder, high.cpus, high.autostart) == (Path("/robots"), (), True)


def test_a_relative_workspace_is_in_the_folder_of_the_file_and_home_is_known() -> None:
    near, _ = read({"env": {"workspace_root": "ws"}, "nodes": []})
    far, _ = read({"env": {"workspace_root": "~/ws"}, "nodes": []})
    assert near.sessions[0].workspace == HERE / "ws"
    assert far.sessions[0].workspace == Path.home() / "ws"


def test_all_of_the_superset_is_read() -> None:
    one, faults = program(
        env={"A": 1, "B": "x y"},
        restart={"policy": "always", "limit": 7, "backoff_s": 20, "stable_s": 3},
        after={"other": "log: ready [0-9]+"},
        after_timeout_s=2.5,
        stop_timeout_s=10,
        required=True,
        parameters={"camera": {"fps": 30}, "drive.limits": [1.0, 2.0]},
        backend="ros2",
        pty=True,
    )
    assert not faults
    assert one.environment == {"A": "1", "B": "x y"}
    assert one.restart == RestartPolicy(
        "always", limit=7, first_delay_s=20, longest_delay_s=20, stable_s=3
    )
    assert one.after == {"other": Condition("log", "ready [0-9]+")}
    assert (one.after_timeout_s, one.is_required, one.backend) == (2.5, True, "ros2")
    assert (one.on_a_terminal, one.stop_timeout_s) == (True, 10)
    assert one.parameters == (
        GivenValue("", "camera.fps", 30, "typed"),
        GivenValue("", "drive.limits", [1.0, 2.0], "typed"),
    )


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("other", Condition("started")),
        (["other"], Condition("started")),
        ([{"other": "handshake"}], Condition("handshake")),
        ({"other": "lifecycle  active"}, Condition("lifecycle active")),
        ({"other": "exit 0"}, Condition("exit 0")),
        ({"other": None}, Condition("started")),
        ({"other": {"log": "a: b"}}, Condition("log", "a: b")),
        ({"other": "log:ready"}, Condition("log", "ready")),
    ],
)
def test_conditions_have_several_forms(written: object, meant: Condition) -> None:
    one, faults = program(after=written)
    assert not faults
    assert one.after == {"other": meant}


@pytest.mark.parametrize(
    ("pattern", "is_refused"),
    [
        ("(a+)+$", True),
        ("((a*b)c){2,}", True),
        (r"x(\w+\s?)*$", True),
        ("(?:[^)]+ )*", True),
        ("(a+)b+", False),
        (r"(\(a+\))?", False),
        (r"([+*)]b)+ \++", False),
        (r"port [0-9]+ (is|was) \(\d+\)", False),
        ("(ab)+c+", False),
        ("(a+){2}", False),
        ("[]+*]+(ok)+", False),
    ],
)
def test_a_pattern_that_may_take_for_ever_is_refused(pattern: str, is_refused: bool) -> None:
    _, faults = program(after={"other": {"log": pattern}})
    assert [("repeats a repetition" in fault) for fault in faults] == [True] * is_refused


def test_parameter_files_are_in_the_project() -> None:
    one, faults = program(parameters=["a.yaml", "/etc/b.toml"], project="robot")
    assert not faults
    assert one.parameter_files == (HERE / "robot/a.yaml", Path("/etc/b.toml"))


WRONG = '''\
speed = 3
[env]
session_nam = "demo"
workspace_root = ["a"]

[[nodes]]
name = "a"
command = """
python \\
 run.py"""
autostart = "yes"   # no [ flag
cpus = "7-4"

[[nodes]]
name = "a"
comand = "x"
restart = { policy = "allways", limit = -1 }
[nodes.env]
"1A" = "x"
[nodes.after]
b = "handshak"
a = "started"

[[nodes]]
name = "b c"
command = []
after = ["c", "nobody"]
required = 1
parameters = { x = { y = [[1]] } }

[[nodes]]
project = 3
[[nodes]]
name = "c"
command = "x"
after = { "d" = "log: (" }
after_timeout_s = "2"
[[nodes]]
name = "d"
command = "x"
after = "c"
'''


def test_every_mistake_is_named_with_its_line_all_at_once() -> None:
    assert faults_of(WRONG) == [
        "robot.toml:1: the file has no 'speed'; it has env, nodes",
        "robot.toml:3: env has no 'session_nam'; did you mean session_name?",
        "robot.toml:4: workspace_root is a text, not a list",
        "robot.toml:11: autostart is true or false, not a text: 'yes'",
        "robot.toml:12: cpus is a list such as 7, 4-5 or 0,2, not '7-4'",
        "robot.toml:14: program 'a' has no command",
        "robot.toml:15: two programs are called 'a' (line 7)",
        "robot.toml:16: program 'a' has no 'comand'; did you mean command?",
        "robot.toml:17: policy is one of never, on-failure, always, not 'allways'; "
        "did you mean always?",
        "robot.toml:17: limit is a whole number from 0 on, not a number: '-1'",
        "robot.toml:19: env: '1A' is no environment variable",
        "robot.toml:21: there is no condition 'handshak'; did you mean handshake?",
        "robot.toml:21: after: no program is called 'b'",
        "robot.toml:22: 'a' waits for itself",
        "robot.toml:25: the name 'b c' has blanks, or one of / : , or begins with -",
        "robot.toml:26: program 'b c' has an empty list of commands",
        "robot.toml:27: after: no program is called 'nobody'",
        "robot.toml:28: required is true or false, not a number: '1'",
        "robot.toml:29: parameter x.y is neither a value nor a list",
        "robot.toml:31: program 4 has no name",
        "robot.toml:31: program 4 has no command",
        "robot.toml:36: the pattern '(' is no regular expression: "
        "missing ), unterminated subpattern at position 0",
        "robot.toml:36: programs wait for each other: c after d after c",
        "robot.toml:37: after_timeout_s is a number from 0 on, not a text: '2'",
    ]


@pytest.mark.parametrize(
    ("config", "fault"),
    [
        ({}, "the file has no nodes"),
        ({"nodes": {}}, "nodes is a list of programs, not a mapping"),
        ({"sessions": []}, "the list of sessions is empty"),
        ({"sessions": None}, "the list of sessions is empty"),
        ({"sessions": {"a": 1}}, "sessions is a list of sessions, not a mapping"),
        ({"sessions": [3]}, "session 1 is a mapping, not a number"),
        ({"sessions": [{"nodes": []}], "nodes": []}, "a file with sessions has no 'nodes'"),
        ({"nodes": ["x"]}, "program 1 is a mapping, not a text"),
        ({"nodes": [{"name": "a", "command": " "}]}, "program 'a' has an empty command"),
        ({"env": 3, "nodes": []}, "env is a mapping, not a number"),
    ],
)
def test_a_file_of_another_form_says_what_is_wrong(config: dict[str, Any], fault: str) -> None:
    assert any(one.startswith(fault) for one in read(config)[1])


@pytest.mark.parametrize(
    ("keys", "fault"),
    [
        ({"project": "~nobody_at_all/x"}, "project: there is no home folder ~nobody_at_all"),
        ({"parameters": "~nobody_at_all/x"}, "parameters: there is no home folder ~nobody_at_all"),
        ({"command": "a\0b"}, "command has a NUL character"),
        ({"command": ["x", "\ud800"]}, "command has half of a surrogate pair"),
        ({"command": "x" * 130_000}, "command has more than 120000 bytes"),
        ({"project": "a\0b"}, "project has a NUL character"),
        ({"env": {"X": "\ud800"}}, "env: 'X' has half of a surrogate pair"),
        ({"env": {"X": "a\0b"}}, "env: 'X' has a NUL character"),
        ({"env": {"X": "x" * 130_000}}, "env: 'X' has more than 120000 bytes"),
        ({"name": ""}, "program 1 has an empty name"),
        ({"cpus": ""}, "cpus is a list such as"),
    ],
)
def test_a_text_that_no_program_can_be_given_is_a_mistake(keys: dict[str, Any], fault: str) -> None:
    assert [one[: len(fault)] for one in program(**keys)[1]] == [fault]


@pytest.mark.parametrize("key", ["workspace_root", "ros_setup"])
def test_a_home_that_nobody_has_is_a_mistake(key: str) -> None:
    _, faults = read({"env": {key: "~nobody_at_all/x"}, "nodes": []})
    assert faults == [f"{key}: there is no home folder ~nobody_at_all"]


def test_data_that_contains_itself_is_a_mistake() -> None:
    config: dict[str, Any] = {"nodes": []}
    config["env"] = config
    assert read(config)[1] == ["nested too deeply"]


def test_a_mapping_may_have_keys_of_the_users_own() -> None:
    assert not read({"x-common": {"a": [1]}, "nodes": []})[1]
    assert not read({"x-common": 1, "sessions": [{"nodes": []}]})[1]


@pytest.mark.parametrize("name", ["robot", "robot.txt"])
def test_a_file_whose_name_tells_no_format_is_refused(name: str) -> None:
    with pytest.raises(ConfigurationError, match=r"none of .yaml, .yml and .toml"):
        read_text("", HERE / name, Faults(name))


def test_a_suffix_may_be_in_capitals() -> None:
    faults = Faults("robot.TOML")
    assert list(read_text('[[nodes]]\nname="a"\ncommand="b"', HERE / "a.TOML", faults).programs)
    assert not faults.in_order()


def test_text_that_is_no_toml_is_named_with_its_line() -> None:
    [fault] = faults_of('[env]\nsession_name = "demo\n')
    assert fault.startswith("robot.toml:2: not TOML: ")


def test_programs_of_one_name_in_two_sessions_are_told_apart_by_their_session() -> None:
    def session(name: str) -> dict[str, Any]:
        nodes = [
            {"name": "camera", "command": "x"},
            {"name": f"only_{name}", "command": "x", "after": "camera"},
        ]
        return {"env": {"session_name": name}, "nodes": nodes}

    description, faults = read({"sessions": [session("left"), session("right")]})
    assert not faults
    keys = [one.key for one in description.programs]
    assert keys == ["left/camera", "only_left", "right/camera", "only_right"]
    assert [list(one.after) for one in description.programs][1::2] == [
        ["left/camera"],
        ["right/camera"],
    ]
    programs = list(description.programs)
    assert choose(programs, disable=["camera"]) == ["only_left", "only_right"]
    assert choose(programs, disable=["left/camera"]) == ["only_left", "right/camera", "only_right"]


def test_a_program_of_another_session_is_found_unless_it_may_be_several() -> None:
    first = {"env": {"session_name": "a"}, "nodes": [{"name": "x", "command": "x"}]}
    second = {"env": {"session_name": "b"}, "nodes": [{"name": "x", "command": "x"}]}
    third = {
        "env": {"session_name": "c"},
        "nodes": [{"name": "y", "command": "x", "after": ["x", "a/x"]}],
    }
    description, faults = read({"sessions": [first, second, third]})
    assert faults == ["after: 'x' may be a/x, b/x"]
    assert list(list(description.programs)[2].after) == ["a/x"]


def test_disabled_beats_enabled_which_beats_autostart() -> None:
    nodes = [
        {"name": name, "command": "x", "autostart": name in "ab"} for name in ("a", "b", "c", "d")
    ]
    programs = list(read({"nodes": nodes})[0].programs)
    assert choose(programs) == ["a", "b"]
    assert choose(programs, enable=["c", "b"], disable=["b"]) == ["a", "c"]
    assert choose(programs, enable=["d"], disable=["d"]) == ["a", "b"]
    with pytest.raises(ConfigurationError, match=r"no program is called 'e'; there are a, b, c, d"):
        choose(programs, disable=["e"])


@given(launcher_data)
def test_whatever_a_file_holds_is_read_or_refused_but_never_fails(config: dict[str, Any]) -> None:
    description, _ = read(config)
    keys = [one.key for one in description.programs]
    assert all(one.folder.is_absolute() for one in description.programs)
    assert all(other in keys for one in description.programs for other in one.after)


@given(st.text() | launcher_data.map(str))
def test_whatever_text_a_file_has_is_read_or_refused_but_never_fails(text: str) -> None:
    assert all(fault.startswith("robot.toml:") for fault in faults_of(text))


@given(waiting_programs())
def test_programs_start_behind_the_ones_that_they_wait_for(after: dict[str, list[str]]) -> None:
    order = in_order(after)
    assert sorted(order) == sorted(after)
    assert all(order.index(other) < order.index(name) for name in after for other in after[name])
    assert not circles(after)
    if not any(after.values()):
        assert order == list(after)


@given(waiting_programs(), st.data())
def test_a_circle_is_found(after: dict[str, list[str]], data: st.DataObject) -> None:
    last = data.draw(st.sampled_from(list(after)))
    steps = data.draw(st.integers(0, 8))
    # Somebody whom it waits for, directly or not, waits for it as well; or it waits for itself.
    first = last
    for _ in range(steps):
        first = next(iter(after[first]), first)
    after[first] = [*after[first], last]
    [circle, *_] = circles(after)
    for name, following in zip(circle, [*circle[1:], circle[0]], strict=True):
        assert following in after[name]


@given(st.sets(st.integers(0, 300), min_size=1))
def test_a_list_of_cpus_is_read_in_every_form(cpus: set[int]) -> None:
    assert read_cpus(",".join(map(str, cpus))) == tuple(sorted(cpus))
    first, last = min(cpus), max(cpus)
    assert read_cpus(f"{first}-{last}") == tuple(range(first, last + 1))
    assert read_cpus(f"{first}-{last}:2, {last}") == tuple(
        sorted({*range(first, last + 1, 2), last})
    )


@pytest.mark.parametrize("text", ["", "a", "1-", "-1", "2-1", "1,,2", "1-3:0", "1.5", "²", "9" * 9])
def test_what_is_no_list_of_cpus_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match="is no list of CPUs"):
        read_cpus(text)


VALUES = (
    *("1", '"a # b"', "'[['", "[1, [2]]", '["]", "#"]', "[\n 1, # ]\n 2 ]", '"""a\n[b]\n"""'),
    *("""'''\nx = 1\n'''""", "{ z = 1 }", '"""\\""" = 2\n"""', "1979-05-27"),
)


@given(
    st.lists(st.tuples(program_names, st.sampled_from([*VALUES, ""])), max_size=8), st.booleans()
)
def test_the_line_of_every_key_is_found(keys: list[tuple[str, str]], ends: bool) -> None:
    wanted: dict[tuple[str | int, ...], int] = {}
    table: tuple[str | int, ...] = ("list", 0)
    text = "# [x]\n\n[[list]]\n"
    for number, (name, value) in enumerate(keys):
        key = f"{name}{number}"
        line = text.count("\n") + 1
        if value:
            text += f'"{key}" = {value}  # y = 1\n'
            wanted[table + (key,)] = line  # noqa: RUF005 - Python 3.10 knows no star here
        else:
            text += f'[list."{key}"]\n'
            table = ("list", 0, key)
            wanted[table] = line
    lines = lines_of(text.rstrip("\n") if ends else text)
    parse_toml(text)
    assert {path: lines[path] for path in wanted} == wanted
