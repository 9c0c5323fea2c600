"""What users write on the command line and in parameter files, as checked values."""

import argparse
import difflib
import math
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from rosbase.errors import ConfigurationError, ParameterError
from rosbase.parameters import ParameterSpec, ParameterValue, check_value, parse_text

__all__ = ["OneLineParser", "positive_number", "read_parameters"]


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose complaints are one line."""

    def error(self, message: str) -> NoReturn:
        """Says what is wrong, and ends with status 2."""
        self.exit(2, f"{self.prog}: {' '.join(message.split())}\n")


def positive_number(text: str) -> float:
    """The number that a user gave for a duration or a rate, for argparse."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not (math.isfinite(number) and number > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a positive number")
    return number


def read_parameters(
    specs: Iterable[ParameterSpec], assignments: Iterable[str], file: Path | None
) -> dict[str, ParameterValue]:
    """The values from a TOML file and from `name:=value` assignments, which win.

    Raises:
        ConfigurationError: The file cannot be read, a name is unknown, or a value is not
            one of its parameter.
    """
    known = {spec.name: spec for spec in specs}
    values: dict[str, ParameterValue] = {}
    for name, value in _read_file(file).items():
        values[name] = check_value(_spec(known, name), value)
    for assignment in assignments:
        name, separator, text = assignment.partition(":=")
        if not separator:
            raise ParameterError(f"-p takes name:=value, not {assignment!r}")
        values[name.strip()] = parse_text(_spec(known, name.strip()), text)
    return values


def _spec(known: Mapping[str, ParameterSpec], name: str) -> ParameterSpec:
    if name in known:
        return known[name]
    near = difflib.get_close_matches(name, known, n=1)
    hint = f"; did you mean {near[0]}?" if near else ""
    raise ParameterError(f"unknown parameter {name!r}{hint}")


def _read_file(file: Path | None) -> dict[str, Any]:
    if file is None:
        return {}
    try:
        return _flatten(tomllib.loads(file.read_text(encoding="utf-8")))
    except OSError as error:
        raise ConfigurationError(f"{file}: {error.strerror}") from error
    except ValueError as error:
        # TOML's own errors and those of UTF-8 are both of this kind.
        raise ConfigurationError(f"{file}: {' '.join(str(error).split())}") from error


def _flatten(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            flat |= _flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat
