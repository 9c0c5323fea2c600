"""Read the text of a file, or a mapping of a program, into a description."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosbase.errors import ConfigurationError
from rosbase.launcher.description.model import Description
from rosbase.launcher.description.sessions import read_description
from rosbase.launcher.description.toml_tree import read_toml
from rosbase.launcher.description.tree import Faults, Value, as_tree

__all__ = ["read_mapping", "read_text"]

_YAML, _TOML = (".yaml", ".yml"), ".toml"
_NAMELESS = "rosbase"


def read_text(text: str, path: Path, faults: Faults) -> Description:
    """Return the description in the text of a file, after noting every mistake in it.

    Args:
        text: The text.
        path: The file; its name decides between YAML and TOML.
        faults: Where mistakes are noted.

    Raises:
        ConfigurationError: The name tells no format, or the file is YAML, and PyYAML is not
            installed.
    """
    suffix = path.suffix.lower()
    if suffix not in (*_YAML, _TOML):
        raise ConfigurationError(f"{path}: the name ends in none of .yaml, .yml and .toml")
    tree = read_toml(text, faults) if suffix == _TOML else _yaml(text, faults)
    if tree is None:
        return Description((), faults.file)
    return read_description(tree, path.absolute().parent, path.stem, faults)


def read_mapping(config: Mapping[str, Any], folder: Path, faults: Faults) -> Description:
    """Return the description in a mapping that a program has made; relative to that folder."""
    try:
        tree = as_tree(config)
    except RecursionError:
        faults.add(0, "nested too deeply")
        return Description(())
    return read_description(tree, folder, _NAMELESS, faults)


def _yaml(text: str, faults: Faults) -> Value | None:
    try:
        # Only now: it is not among the requirements of rosbase-core.
        from rosbase.launcher.description.yaml_tree import read_yaml  # noqa: PLC0415 - as said
    except ImportError:
        raise ConfigurationError(f"{faults.file}: YAML needs PyYAML: pip install pyyaml") from None
    return read_yaml(text, faults)
