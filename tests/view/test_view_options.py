"""Arguments of `rosbase view`."""

import argparse

import pytest

from rosbase import ConfigurationError
from rosbase_view import command
from rosbase_view.options import Options, add_arguments, options_of


def parsed(*words: str) -> Options:
    parser = argparse.ArgumentParser()
    add_arguments(parser)

    def refuse(text: str) -> None:
        raise ConfigurationError(text)

    return options_of(parser.parse_args(words), refuse)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("", ("terminal", None, 0)),
        ("quadruped", ("terminal", "quadruped", 0)),
        ("--web", ("web", None, 8080)),
        ("--web 9000", ("web", None, 9000)),
        ("--web quadruped", ("web", "quadruped", 8080)),
        ("quadruped --web", ("web", "quadruped", 8080)),
        ("--foxglove", ("foxglove", None, 8765)),
        ("--foxglove 0 quadruped", ("foxglove", "quadruped", 0)),
        ("--web 2026-11-29.mcap", ("web", "2026-11-29.mcap", 8080)),
        ("--foxglove field.mcap", ("foxglove", "field.mcap", 8765)),
    ],
)
def test_a_word_behind_an_option_is_a_port_or_a_name(
    words: str, expected: tuple[str, str | None, int]
) -> None:
    options = parsed(*words.split())
    assert (options.view, options.name, options.port) == expected
    assert options.host == "127.0.0.1"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        ("--web x quadruped", "'x' is no port"),
        ("--web 65536", "there is no port 65536"),
        ("--web 80a", "'80a' is no port"),
        ("--foxglove -5", "'-5' is no port"),
    ],
)
def test_a_mistake_is_one_line(words: str, reason: str) -> None:
    with pytest.raises(ConfigurationError, match=reason):
        parsed(*words.split())


@pytest.mark.parametrize(("view", "package"), [("web", "viser"), ("foxglove", "foxglove-sdk")])
def test_a_library_that_is_missing_is_named_with_its_command(
    view: str, package: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command, "find_spec", lambda _: None)
    parser = argparse.ArgumentParser()
    command.configure(parser)
    arguments = parser.parse_args([f"--{view}"])
    with pytest.raises(ConfigurationError, match=f"--{view} needs .*: pip install '{package}>="):
        command.run(arguments)
