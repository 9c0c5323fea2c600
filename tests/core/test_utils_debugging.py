"""`--debug`: with a stand-in for debugpy, and without debugpy."""

import argparse
import sys
from typing import Any, cast

import pytest

from rosbase.utils import add_debug_mode


class Debugpy:
    """Notes what it is asked for."""

    def __init__(self) -> None:
        self.calls: list[Any] = []

    def listen(self, address: tuple[str, int]) -> None:
        if address[1] == 1:
            raise OSError(98, "Address already in use")
        self.calls.append(address)

    def wait_for_client(self) -> None:
        self.calls.append("waited")


@pytest.fixture
def debugpy(monkeypatch: pytest.MonkeyPatch) -> Debugpy:
    stand_in = Debugpy()
    monkeypatch.setitem(sys.modules, "debugpy", cast("Any", stand_in))
    monkeypatch.setattr(sys, "argv", ["app.py"])
    return stand_in


def test_a_parser_gets_the_argument_and_waits_while_it_parses(
    debugpy: Debugpy, capsys: pytest.CaptureFixture[str]
) -> None:
    parser = argparse.ArgumentParser()
    assert add_debug_mode(parser, listen_port=7000) is parser
    assert parser.parse_args([]).debug is False
    assert debugpy.calls == []
    assert parser.parse_args(["--debug"]).debug is True
    assert debugpy.calls == [("127.0.0.1", 7000), "waited"]
    assert capsys.readouterr().err == "waiting for a debugger on port 7000\n"
    assert "port 7000" in parser.format_help()


def test_without_a_parser_the_command_line_is_read_and_left_as_it_is(
    debugpy: Debugpy, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert add_debug_mode().debug is False
    monkeypatch.setattr(sys, "argv", ["app.py", "--own", "--debug"])
    assert add_debug_mode(None, listen_port=7001).debug is True
    assert debugpy.calls == [("127.0.0.1", 7001), "waited"]
    assert sys.argv == ["app.py", "--own", "--debug"]


def test_parsed_arguments_are_followed(debugpy: Debugpy) -> None:
    for arguments in (argparse.Namespace(), argparse.Namespace(debug=False)):
        assert add_debug_mode(arguments) is arguments
    assert debugpy.calls == []
    add_debug_mode(argparse.Namespace(debug=True))
    assert debugpy.calls == [("127.0.0.1", 5678), "waited"]


def test_a_missing_debugpy_and_a_port_that_is_taken_are_one_line(
    debugpy: Debugpy, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        add_debug_mode(argparse.Namespace(debug=True), listen_port=1)
    assert ended.value.code == 2
    said = (
        "app.py: error: cannot listen on port 1 for a debugger: [Errno 98] Address already in use\n"
    )
    assert capsys.readouterr().err == said
    # Python's way to say that there is no such module.
    monkeypatch.setitem(sys.modules, "debugpy", None)
    parser = add_debug_mode(argparse.ArgumentParser(prog="walk"))
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["--debug"])
    assert ended.value.code == 2
    said = "walk: error: --debug needs debugpy: pip install debugpy\n"
    assert capsys.readouterr().err == said
