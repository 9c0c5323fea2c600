"""The arguments that every program can take: parameters, backend and log levels."""

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

from rosbase.contracts.recording import RecordOptions
from rosbase.errors import ConfigurationError
from rosbase.logger.environment import FILE_VARIABLES, LEVEL_VARIABLE, levels_in
from rosbase.parameters.given import (
    GIVEN_VARIABLE,
    GivenParameters,
    GivenValue,
    given_parameters,
)
from rosbase.program.files import read_file
from rosbase.roles.connection import BACKEND_VARIABLE
from rosbase.roles.recording import RECORD_VARIABLE

__all__ = ["add_arguments", "take_arguments"]

_FOR_THE_BACKEND = "--ros-args"
_END = "--"
_SHORT = "-p"
_LONG = ("--params-file", "--backend", "--log-level", "--log-file", "--record", "--record-last")
# Linux takes 128 KiB for one variable of the environment.
_MOST_CHARACTERS = 100_000


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise ConfigurationError(message)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `take_arguments` to a parser."""
    parser.add_argument(
        _SHORT,
        dest="assignments",
        metavar="NAME:=VALUE",
        action="append",
        default=[],
        help="set a parameter, such as camera.fps:=30; without a node, for every node",
    )
    parser.add_argument(
        "--params-file",
        dest="files",
        type=Path,
        metavar="FILE",
        action="append",
        default=[],
        help="set parameters from a TOML file, or a YAML file of ROS 2",
    )
    parser.add_argument("--backend", metavar="NAME", help="the backend of programs that name none")
    parser.add_argument(
        "--log-level",
        dest="levels",
        metavar="[NAME:=]LEVEL",
        action="append",
        default=[],
        help="log from this level on: debug, info, warn, error, fatal; for one logger with NAME:=",
    )
    parser.add_argument(
        "--log-file",
        metavar="FILE",
        help="write the log to a file too; at 10 MB a new one is begun, and 5 old ones are kept",
    )
    parser.add_argument(
        "--record",
        metavar="FILE",
        help="record topics, parameters, transitions and log to a file, such as run.mcap",
    )
    parser.add_argument(
        "--record-last",
        metavar="SECONDS",
        type=float,
        help="keep only the last seconds in memory, and write them if an error ends the program",
    )


def take_arguments(
    arguments: Sequence[str] | None = None, *, before: argparse.Namespace | None = None
) -> list[str]:
    """Take the arguments of `rosbase run` from a command line, and return the others.

    These are `-p name:=value`, `--params-file FILE`, `--backend NAME`,
    `--log-level [NAME:=]LEVEL`, `--log-file FILE`, `--record FILE` and `--record-last SECONDS`.
    They apply to managers and nodes that are built later in this process and in its child
    processes; the recording is of the first of them. Arguments after `--ros-args` are left
    alone, and so are those after a `--`, which is left out.

    Args:
        arguments: The command line without the program; by default this process's.
        before: Parsed arguments to which these are added.

    Raises:
        ConfigurationError: An argument or a file is invalid. The message is one line.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    limits = [words.index(word) for word in (_FOR_THE_BACKEND, _END) if word in words]
    end = min(limits, default=len(words))
    ours, others = _split(words[:end])
    parser = _Parser(add_help=False, allow_abbrev=False)
    add_arguments(parser)
    apply(parser.parse_args(ours, before))
    return [*others, *words[end + (words[end : end + 1] == [_END]) :]]


def _split(words: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split our options, with their values, from everything else: `-port` is none of ours."""
    ours: list[str] = []
    others: list[str] = []
    is_value = False
    for word in words:
        is_option = word in (*_LONG, _SHORT)
        is_both = word.startswith(tuple(f"{option}=" for option in _LONG)) or (
            word.startswith(_SHORT) and ":=" in word
        )
        (ours if is_value or is_option or is_both else others).append(word)
        is_value = is_option and not is_value
    return ours, others


def apply(taken: argparse.Namespace) -> None:
    """Apply parsed arguments to the managers and nodes of this process.

    Raises:
        ConfigurationError: An argument or a file is invalid.
    """
    values = [value for file in taken.files for value in read_file(file)]
    values += [_assigned(text) for text in taken.assignments]
    if values:
        text = GivenParameters([*given_parameters().values, *values]).to_json()
        if len(text) > _MOST_CHARACTERS:
            raise ConfigurationError(
                f"the parameters are too long: {len(text)} characters of {_MOST_CHARACTERS}"
            )
        os.environ[GIVEN_VARIABLE] = text
    if taken.backend:
        os.environ[BACKEND_VARIABLE] = taken.backend
    if taken.levels:
        text = ",".join(taken.levels)
        levels_in(text)
        os.environ[LEVEL_VARIABLE] = text
    if taken.log_file:
        os.environ[FILE_VARIABLES[0]] = taken.log_file
    if taken.record:
        options = RecordOptions(taken.record, last_s=taken.record_last)
        os.environ[RECORD_VARIABLE] = options.to_text()
    elif taken.record_last is not None:
        raise ConfigurationError("--record-last needs --record FILE")


def _assigned(text: str) -> GivenValue:
    name, separator, value = text.partition(":=")
    if not (separator and name.strip()):
        raise ConfigurationError(f"-p takes name:=value, not {text!r}")
    return GivenValue("", name.strip(), value, "text")
