"""The table of the commands for running programs, and how command lines are read by it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.cli import _QUICK
from rosbase.cli.operate import run
from rosbase.cli.operate.entries import Argument, Command, Option
from rosbase.cli.operate.helping import command_help
from rosbase.cli.operate.reading import UsageError, WantsHelp, find, read
from rosbase.cli.operate.words import GROUPS, all_options

COMMANDS = {
    name: command
    for first, entry in GROUPS.items()
    for name, command in (
        [(first, entry)]
        if isinstance(entry, Command)
        else [(f"{first} {word}", command) for word, command in entry.commands.items()]
    )
}
TRIED = Command(
    "try",
    "module.function",
    Argument("topic", "a topic"),
    Argument("values", "values", needed=False),
    Option("-r --rate", "a rate", value="HZ", kind="positive", default=1.0),
    Option("-c --count", "count"),
    Option("-t --times", "times", value="N", kind="whole"),
    Option("--tag", "tags", value="TAG", many=True),
)


@pytest.mark.parametrize(
    ("line", "values"),
    [
        ("/x", {"topic": "/x", "values": None, "rate": 1.0, "count": False, "tag": []}),
        ("-r 5 /x", {"topic": "/x", "rate": 5.0}),
        ("/x --rate=5 -c", {"rate": 5.0, "count": True}),
        ("/x -r5", {"rate": 5.0}),
        ("/x -cr 5", {"rate": 5.0, "count": True}),
        ("/x --ra 5", {"rate": 5.0}),
        ("/x -1.5", {"values": "-1.5"}),
        ("-- /x -c", {"values": "-c", "count": False}),
        ("/x --tag a --tag b", {"tag": ["a", "b"]}),
        ("/x -P robot", {"program": "robot"}),
        ("/x -t 3", {"times": 3}),
        ("/x -.inf", {"values": "-.inf"}),
        ("/x -0x10", {"values": "-0x10"}),
        ("/x -inf", {"values": "-inf"}),
    ],
)
def test_options_stand_anywhere_in_each_of_their_spellings(
    line: str, values: dict[str, object]
) -> None:
    found = read(TRIED, line.split())
    assert {name: found[name] for name in values} == values


@pytest.mark.parametrize(
    ("line", "text"),
    [
        ("", "TOPIC is missing"),
        ("/x y z", "unrecognized arguments: z"),
        ("/x --fast", "unrecognized arguments: --fast"),
        ("/x -z", "unrecognized arguments: -z"),
        ("/x --t 3", "unrecognized arguments: --t: could be --times, --tag"),
        ("/x -r", "-r takes a value: HZ"),
        ("/x -r nan", "-r: 'nan' is not a positive number"),
        ("/x --rate=-5", "--rate: '-5' is not a positive number"),
        ("/x -t 0", "-t: '0' is not a whole number from 1 up"),
        (f"/x -t {'5' * 5_000}", "-t: '555"),
        ("/x --count=3", "--count takes no value"),
    ],
)
def test_a_wrong_line_is_explained(line: str, text: str) -> None:
    with pytest.raises(UsageError) as caught:
        read(TRIED, line.split())
    assert str(caught.value).startswith(text)


def test_an_option_may_look_like_a_number() -> None:
    found = read(COMMANDS["topic pub"], ["-1", "/goal", "geometry_msgs/msg/Point", "{x: 1}"])
    assert (found["once"], found["topic"], found["values"]) == (True, "/goal", "{x: 1}")


@given(st.lists(st.text(st.sampled_from("-=cr5/x P"), max_size=5), max_size=5))
def test_any_line_is_read_or_refused(words: list[str]) -> None:
    try:
        read(TRIED, words)
    except (UsageError, WantsHelp):
        pass


def test_the_quick_way_knows_every_command_of_the_table() -> None:
    assert {"_complete", *GROUPS} == _QUICK


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_its_function_and_its_help(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    command = COMMANDS[name]
    module, _, function = command.does.partition(".")
    found = __import__(f"rosbase.cli.operate.{module}", fromlist=[function])
    assert callable(getattr(found, function))
    assert run([*name.split(), "--help"]) == 0
    shown = capsys.readouterr().out
    assert shown == command_help(name, command) + "\n"
    assert all(flag in shown for option in all_options(command) for flag in option.flags)
    assert max(map(len, shown.splitlines())) <= 130


@pytest.mark.parametrize("name", COMMANDS)
def test_no_two_options_of_a_command_are_alike(name: str) -> None:
    flags = [flag for option in all_options(COMMANDS[name]) for flag in option.flags]
    keys = [option.key for option in all_options(COMMANDS[name])]
    keys += [argument.key for argument in COMMANDS[name].arguments]
    assert len(flags) == len(set(flags))
    assert len(keys) == len(set(keys))


def test_a_group_alone_lists_its_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["topic", "--help"]) == 0
    shown = capsys.readouterr().out
    assert all(f"  {word} " in shown for word in find(["topic"])[1].commands)  # type: ignore[union-attr]  # a group
    assert run(["topic"]) == 2
    assert "give a command: list, info" in capsys.readouterr().err
    assert run(["topic", "fly"]) == 2
    assert "no command 'topic fly'" in capsys.readouterr().err
