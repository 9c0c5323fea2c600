"""Parse and check values on the command line and in parameter files."""

import argparse
import math
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from attrs import frozen

from rosbase.errors import ConfigurationError, ParameterError
from rosbase.parameters import (
    ParameterSpec,
    ParameterValue,
    did_you_mean,
    from_outside,
    parse_text,
)
from rosbase.program.files import read_toml
from rosbase.text.printable import MOST_LINE, one_line

__all__ = [
    "Given",
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
        "--params-file", type=Path, metavar="FILE", help="set parameters from a TOML file"
    )


@frozen
class Given:
    """A value from a user, not yet checked."""

    value: Any
    is_text: bool
    """Whether it was typed after `:=`, so that it must be parsed first."""


def read_given(assignments: Iterable[str], file: Path | None) -> dict[str, Given]:
    """Return the values in a TOML file and in `name:=value` assignments, by name; assignments win.

    Raises:
        ConfigurationError: The file cannot be read, or an assignment is not one.
    """
    given = {name: Given(value, is_text=False) for name, value in _read_file(file).items()}
    for assignment in assignments:
        name, separator, text = assignment.partition(":=")
        if not separator:
            raise ParameterError(f"-p takes name:=value, not {assignment!r}")
        given[name.strip()] = Given(text, is_text=True)
    return given


def with_spellings(given: Mapping[str, Given], spellings: Mapping[str, str]) -> dict[str, Given]:
    """Return the given values by parameter name; `spellings` has other accepted names.

    Raises:
        ParameterError: A parameter was given in two spellings.
    """
    for spelling, name in spellings.items():
        if spelling in given and name in given:
            raise ParameterError(f"{spelling} and {name} are one parameter: give one of them")
    return {spellings.get(name, name): value for name, value in given.items()}


def check_given(
    specs: Iterable[ParameterSpec], given: Mapping[str, Given]
) -> dict[str, ParameterValue]:
    """Return the checked values of the given parameters.

    Raises:
        ParameterError: A name is unknown, or a value is invalid for its parameter.
    """
    known = {spec.name: spec for spec in specs}
    return {
        name: (parse_text if item.is_text else from_outside)(_spec(known, name), item.value)
        for name, item in given.items()
    }


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


def _read_file(file: Path | None) -> dict[str, Any]:
    if file is None:
        return {}
    try:
        return read_toml(file)
    except ConfigurationError as error:
        is_of_ros = file.suffix in (".yaml", ".yml") and file.exists()
        hint = "; a parameter file of ROS is given behind --ros-args" if is_of_ros else ""
        raise ConfigurationError(f"{error}{hint}") from error
