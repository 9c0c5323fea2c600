"""Parse and check values on the command line and in parameter files."""

import argparse
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NoReturn

from rosbase.errors import ConfigurationError, ParameterError
from rosbase.parameters import (
    ParameterSpec,
    ParameterValue,
    did_you_mean,
)
from rosbase.parameters.given import GivenValue, read_value, values_of
from rosbase.program.files import read_file, read_toml
from rosbase.text.printable import MOST_LINE, one_line

__all__ = [
    "OneLineParser",
    "add_device_arguments",
    "add_parameters",
    "as_text",
    "check_given",
    "number_between",
    "positive_number",
    "read_given",
    "with_spellings",
]


class OneLineParser(argparse.ArgumentParser):
    """An argument parser with error messages of one line."""

    def error(self, message: str) -> NoReturn:
        """Print the error, and exit with status 2."""
        self.exit(2, f"{self.prog}: {one_line(message, MOST_LINE)}\n")


def positive_number(text: str) -> float:
    """Return the number that a user gave for a duration, for argparse."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return number


def number_between(least: float, most: float) -> Callable[[str], float]:
    """Return a parser of positive numbers from `least` to `most`, for argparse."""

    def read(text: str) -> float:
        number = positive_number(text)
        if not least <= number <= most:
            raise argparse.ArgumentTypeError(f"{text!r} is not from {least:g} to {most:g}")
        return number

    return read


def add_device_arguments(parser: argparse.ArgumentParser, most_hz: float) -> None:
    """Add the arguments that choose a simulated device, up to a rate."""
    parser.add_argument("--transport", default="serial", metavar="NAME", help="the link (serial)")
    parser.add_argument(
        "--rate",
        type=number_between(0.01, most_hz),
        default=100.0,
        metavar="HZ",
        help="samples per second (100)",
    )


def add_parameters(parser: argparse.ArgumentParser) -> None:
    """Add the two arguments with which users set parameters."""
    parser.add_argument(
        "-p",
        dest="assignments",
        metavar="NAME:=VALUE",
        action="append",
        default=[],
        help="set a parameter, such as device_path:=/dev/ttyUSB0",
    )
    parser.add_argument(
        "--params-file",
        type=Path,
        metavar="FILE",
        help="set parameters from a TOML file, or a YAML file of ROS 2",
    )


def read_given(assignments: Iterable[str], file: Path | None) -> dict[str, GivenValue]:
    """Return the values in a file and in `name:=value` assignments, by name; assignments win.

    In a YAML file of ROS 2, they are those of the reader's node.

    Raises:
        ConfigurationError: The file cannot be read, or an assignment is not one.
    """
    given = _read_file(file)
    for assignment in assignments:
        name, separator, text = assignment.partition(":=")
        if not separator:
            raise ParameterError(f"-p takes name:=value, not {assignment!r}")
        given[name.strip()] = GivenValue("", name.strip(), text, "text")
    return given


def with_spellings(
    given: Mapping[str, GivenValue], spellings: Mapping[str, str]
) -> dict[str, GivenValue]:
    """Return the given values by parameter name; `spellings` has other accepted names.

    Raises:
        ParameterError: A parameter was given in two spellings.
    """
    for spelling, name in spellings.items():
        if spelling in given and name in given:
            raise ParameterError(f"{spelling} and {name} are one parameter: give one of them")
    return {spellings.get(name, name): value for name, value in given.items()}


def check_given(
    specs: Iterable[ParameterSpec], given: Mapping[str, GivenValue]
) -> dict[str, ParameterValue]:
    """Return the checked values of the given parameters.

    Raises:
        ParameterError: A name is unknown, or a value is invalid for its parameter.
    """
    known = {spec.name: spec for spec in specs}
    return {name: read_value(_spec(known, name), item) for name, item in given.items()}


def as_text(value: ParameterValue) -> str:
    """Return the value as a user types it after `:=`."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(str(item[0] if isinstance(item, bytes) else item) for item in value)}]"
    return str(value)


def _spec(known: Mapping[str, ParameterSpec], name: str) -> ParameterSpec:
    if name in known:
        return known[name]
    raise ParameterError(f"unknown parameter {name!r}{did_you_mean(name, known)}")


def _read_file(file: Path | None) -> dict[str, GivenValue]:
    if file is None:
        return {}
    if file.suffix not in (".yaml", ".yml"):
        return {name: GivenValue("", name, v, "typed") for name, v in read_toml(file).items()}
    # Only now: other commands need no reader.
    from rosbase.imu.reader import DEFAULT_NODE_NAME  # noqa: PLC0415 - as said

    found = values_of(read_file(file), DEFAULT_NODE_NAME)
    if not found:
        raise ConfigurationError(f"{file} has no parameters for /{DEFAULT_NODE_NAME}")
    return found
