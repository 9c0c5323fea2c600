"""Parameter files: TOML, or the YAML of ROS 2."""

import datetime
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rosbase.errors import ConfigurationError
from rosbase.parameters import Written, WrittenText
from rosbase.parameters.given import GivenValue
from rosbase.text.printable import one_line
from rosbase.text.toml import parse_toml

__all__ = ["read_file", "read_toml"]

_OF_ROS = (".yaml", ".yml")
_DATES = (datetime.date, datetime.time)
_ANY = "/**"


def read_file(file: Path) -> list[GivenValue]:
    """Return the values in a file.

    In TOML, the table of a node has its parameters, and `["/**"]` has parameters for every node.

    Raises:
        ConfigurationError: The file cannot be read, or is neither TOML nor YAML.
    """
    if file.suffix in _OF_ROS:
        return list(_read_yaml(file))
    values = []
    for name, value in read_toml(file).items():
        if _has_date(value):
            raise ConfigurationError(f"{file}: {name} is a date; write text in quotes")
        values.append(GivenValue("", name.removeprefix(f"{_ANY}."), value, "typed"))
    return values


def _has_date(value: Any) -> bool:
    if isinstance(value, (list, dict)):
        return any(map(_has_date, value.values() if isinstance(value, dict) else value))
    return isinstance(value, _DATES)


def read_toml(file: Path) -> dict[str, Any]:
    """Return the values in a TOML file by dotted name, such as `mapping.time.unit`.

    Raises:
        ConfigurationError: It cannot be read, or is not TOML.
    """
    try:
        return _flatten(parse_toml(_text(file)))
    except RecursionError:
        raise ConfigurationError(f"{file}: nested too deeply") from None
    except ValueError as error:
        raise ConfigurationError(f"{file}: {one_line(str(error))}") from error


def _flatten(table: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return the values of nested tables by dotted name."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict) and value:
            flat |= _flatten(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _read_yaml(file: Path) -> Iterator[GivenValue]:
    try:
        # Only now: most programs need no YAML, and it is not among the requirements.
        from rosbase.parameters.yaml_document import (  # noqa: PLC0415 - as said
            as_written,
            compose,
            entries,
        )
    except ImportError:
        raise ConfigurationError(f"{file}: YAML needs PyYAML: pip install pyyaml") from None
    try:
        documents = compose(_text(file))
    except ValueError as error:
        raise ConfigurationError(f"{file}: {one_line(str(error))}") from error
    found = list(entries(documents))
    if documents and not found:
        raise ConfigurationError(f"{file}: no node has ros__parameters")
    for entry in found:
        written = as_written(entry.node)
        if written is None:
            raise ConfigurationError(f"{file}: {entry.name} is neither a value nor a flat list")
        yield GivenValue(entry.section, entry.name, _plain(written), "yaml")


def _plain(written: Written) -> Any:
    return [_item(item) for item in written] if isinstance(written, tuple) else _item(written)


def _item(item: WrittenText) -> Any:
    if not item.is_quoted and item.data is None:
        return item.text
    data = None if item.data is None else list(item.data)
    return {"text": item.text, "quoted": item.is_quoted, "data": data}


def _text(file: Path) -> str:
    try:
        return file.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigurationError(f"{file}: {error.strerror}") from error
    except ValueError as error:
        raise ConfigurationError(f"{file}: {one_line(str(error))}") from error
