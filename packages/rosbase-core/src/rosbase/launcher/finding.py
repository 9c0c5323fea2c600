"""Find and read the file of a launcher."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rosbase.errors import ConfigurationError
from rosbase.launcher.description import Description, Faults, read_mapping, read_text
from rosbase.launcher.description.outside import at_home
from rosbase.launcher.machine import check_machine
from rosbase.text.printable import one_line

__all__ = ["find_file", "read_checked"]


def find_file(name: str | Path, beside: Path) -> Path:
    """Return the path of a file: in the working directory, else beside the launcher.

    Args:
        name: The name, or an absolute path.
        beside: Folder of the launcher's script.

    Raises:
        ConfigurationError: It is in neither.
    """
    path = at_home(str(name))
    for candidate in (path, beside / path):
        if candidate.is_file():
            return candidate
    if path.is_dir():
        raise ConfigurationError(f"{name} is a folder")
    where = "" if path.is_absolute() else f", neither here nor in {beside}"
    raise ConfigurationError(f"there is no file {name}{where}")


def read_checked(
    config: str | Path | Mapping[str, Any], beside: Path
) -> tuple[Description, Faults]:
    """Return a description, with every mistake in it and everything that this machine lacks.

    Args:
        config: The name of a file, or the description itself.
        beside: Folder of the launcher's script.

    Raises:
        ConfigurationError: The file cannot be found or read.
    """
    if isinstance(config, Mapping):
        faults = Faults()
        description = read_mapping(config, Path.cwd(), faults)
    elif not isinstance(config, (str, Path)):
        kind = type(config).__name__
        raise ConfigurationError(f"a launch is the name of a file, or a mapping, not a {kind}")
    else:
        path = find_file(config, beside)
        faults = Faults(str(path))
        description = read_text(_text(path), path, faults)
    check_machine(description, faults)
    return description, faults


def _text(path: Path) -> str:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ConfigurationError(f"{path}: {error.strerror}") from error
    try:
        # Line ends as in a file that is read as text.
        return data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = error.object.count(b"\n", 0, error.start) + 1
        raise ConfigurationError(f"{path}:{line}: {one_line(str(error))}") from error
