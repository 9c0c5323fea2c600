"""Values from outside: which node they concern, in which order they count, what nobody declares."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.errors import ConfigurationError, ParameterError
from rosbase.parameters import ParameterSpec
from rosbase.parameters.given import (
    GIVEN_VARIABLE,
    GivenParameters,
    GivenValue,
    given_parameters,
)
from rosbase.program.files import read_file

FPS = ParameterSpec("fps", 30)
NAMES = st.sampled_from(["", "/**", "front", "/front", "rear", "*", "f*", "robot"])
PARAMETERS = st.sampled_from(["fps", "front.fps", "rear.fps", "gain"])
VALUES = st.builds(GivenValue, NAMES, PARAMETERS, st.integers(-9, 9), st.just("typed"))


def typed(node: str, name: str, value: object) -> GivenValue:
    return GivenValue(node, name, value, "typed")


@pytest.mark.parametrize(
    ("node", "name"),
    [
        ("", "fps"), ("/**", "fps"), ("", "front.fps"), ("front", "fps"), ("/front", "fps"),
        ("*", "fps"), ("f*t", "fps"), ("robot", "front.fps"), ("/**", "front.fps"),
        ("/**/front", "fps"), ("**/f*", "fps"),
    ],
)  # fmt: skip
def test_a_value_concerns_a_node(node: str, name: str) -> None:
    values = GivenParameters([typed(node, name, 5)])
    assert values.value_for(FPS, ["front"], ["robot"]) == 5
    assert values.unused() == []


@pytest.mark.parametrize(
    ("node", "name"),
    [
        *(("", "rear.fps"), ("rear", "fps"), ("robot", "fps"), ("/**/rear", "fps")),
        *(("fron", "fps"), ("/left/front", "fps"), ("", "x.front.fps")),
    ],
)
def test_a_value_concerns_another_node(node: str, name: str) -> None:
    values = GivenParameters([typed(node, name, 5)])
    assert values.value_for(FPS, ["front"], ["robot"]) is None
    assert len(values.unused()) == 1


@given(st.lists(VALUES, max_size=6))
def test_the_last_value_for_the_node_wins_then_the_last_for_every_node(
    values: list[GivenValue],
) -> None:
    exact = [
        value.value
        for value in values
        if (value.node.strip("/") in ("front", "*", "f*") and value.name == "fps")
        or (value.node in ("", "/**", "robot", "*") and value.name == "front.fps")
    ]
    general = [v.value for v in values if v.node in ("", "/**") and v.name == "fps"]
    expected = (exact or general or [None])[-1]
    assert GivenParameters(values).value_for(FPS, ["front"], ["robot"]) == expected


@given(st.lists(VALUES, max_size=6))
def test_values_survive_the_environment(values: list[GivenValue]) -> None:
    assert GivenParameters.from_json(GivenParameters(values).to_json()).values == values


def test_a_value_is_read_as_the_declared_type_says() -> None:
    text = GivenParameters([GivenValue("", "x", "off", "text")])
    assert text.value_for(ParameterSpec("x", default=True), ["a"]) is False
    assert text.value_for(ParameterSpec("x", "on"), ["a"]) == "off"
    with pytest.raises(ParameterError, match=r"parameter a\.x takes a whole number, not 'off'"):
        text.value_for(ParameterSpec("x", 5), ["a"])


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("pfs", "; did you mean fps?"),
        ("front.fsp", "; did you mean front.fps?"),
        ("elephant", ""),
    ],
)
def test_what_nobody_declares_is_named_with_a_suggestion(name: str, hint: str) -> None:
    values = GivenParameters([typed("", name, 5)])
    values.value_for(FPS, ["front"])
    assert values.unused() == [f"no node declares the parameter {name}{hint}"]


def test_what_is_for_a_node_in_another_process_is_not_named() -> None:
    values = GivenParameters([typed("left", "fps", 5), typed("", "right.fps", 5)])
    said = "no node declares the parameter"
    assert values.unused() == [f"{said} left.fps", f"{said} right.fps"]
    # Each is named once.
    assert values.unused() == []


def test_what_may_be_for_a_node_elsewhere_is_not_named() -> None:
    values = [typed("left", "fps", 5), typed("", "right.fps", 5), typed("", "gain", 5)]
    said = "no node declares the parameter"
    assert GivenParameters(values).unused(["right"]) == [f"{said} left.fps"]
    assert GivenParameters(values).unused(["right", "left"]) == []


@pytest.mark.parametrize(
    ("node", "name"),
    [("", "cam.fps"), ("cam", "fps"), ("/left/cam", "fps"), ("/**", "fps"), ("/*/cam", "fps")],
)
def test_a_node_in_a_namespace_is_known_with_it_and_without(node: str, name: str) -> None:
    values = GivenParameters([typed(node, name, 5)])
    assert values.value_for(FPS, ["cam", "left/cam"]) == 5
    assert values.unused() == []


def test_an_environment_of_somebody_else_is_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(GIVEN_VARIABLE, "fps=3")
    with pytest.raises(ConfigurationError, match="ROSBASE_PARAMETERS cannot be read"):
        given_parameters()


def test_tables_of_toml_are_nodes_and_names(tmp_path: Path) -> None:
    file = tmp_path / "robot.toml"
    file.write_text('speed = 1.5\n["/**"]\ngain = 2\n[front]\nfps = 9\nlens.f = [1, 2]\n')
    assert read_file(file) == [
        typed("", "speed", 1.5), typed("", "gain", 2), typed("", "front.fps", 9),
        typed("", "front.lens.f", [1, 2]),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("name", "text", "why"),
    [
        ("absent.toml", None, "No such file or directory"),
        ("broken.toml", "fps = = 3", "Invalid value"),
        ("dated.toml", "day = 2026-01-01", "day is a date; write text in quotes"),
        ("days.toml", "[a]\nb = [[2026-01-01]]", "a.b is a date; write text in quotes"),
        ("latin.toml", b"name = '\xe4'", "can't decode"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_line(
    tmp_path: Path, name: str, text: str | bytes | None, why: str
) -> None:
    file = tmp_path / name
    if text is not None:
        file.write_bytes(text.encode() if isinstance(text, str) else text)
    with pytest.raises(ConfigurationError) as caught:
        read_file(file)
    assert why in str(caught.value)
    assert str(caught.value).startswith(f"{file}: ")
    assert "\n" not in str(caught.value)
