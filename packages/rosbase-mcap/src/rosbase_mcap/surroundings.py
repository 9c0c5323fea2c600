"""Arguments, environment and versions of a run: noted in a recording, restored for a replay."""

import hashlib
import os
import platform
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from rosbase.plugins import BLOCK_VARIABLE, installed_plugins

__all__ = ["HASH_SEED", "differences", "restored", "restored_environment", "surroundings"]

HASH_SEED = "PYTHONHASHSEED"
"""Variable with the seed on which the order of sets of texts depends."""
_PREFIX = "ROSBASE_"
# Others concern files and sockets of the machine, or are secret.
_NOTED = ("ROSBASE_PARAMETERS", "ROSBASE_LOG_LEVEL", BLOCK_VARIABLE)
# What a user sets for the replay itself.
_KEPT = ("ROSBASE_LOG_FILE", "ROSBASE_LOG_FILE_SIZE", "ROSBASE_LOG_FILE_COUNT")
_DISTRIBUTIONS = ("rosbase-core", "rosbase-mcap")


def surroundings() -> dict[str, Any]:
    """Return what a replay restores, and what it warns of if it is another. It can be JSON."""
    return {
        "argv": list(sys.argv),
        "environment": {name: os.environ[name] for name in _NOTED if name in os.environ},
        "hash_seed": os.environ.get(HASH_SEED, ""),
        "program_sha256": _sha256(sys.argv[0]),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "versions": {name: _version(name) for name in _DISTRIBUTIONS},
        # A reader has the parameters of each transport.
        "transports": sorted(installed_plugins().transports),
    }


def differences(recorded: Mapping[str, Any], program: str) -> list[str]:
    """Return what is different now, in a few words each: it may be why a replay differs.

    Args:
        recorded: What `surroundings` has returned for the recording.
        program: File of the program; one that does not exist is not compared.
    """
    now = surroundings()
    found = []
    for name, what in (("python", "Python"), ("machine", "the machine")):
        old = recorded.get(name)
        if old and old != now[name]:
            found.append(f"{what} is {now[name]}, not {old}")
    versions = recorded.get("versions")
    for name, new in now["versions"].items():
        old = versions.get(name) if isinstance(versions, dict) else None
        if old and old != new:
            found.append(f"{name} is {new}, not {old}")
    old = recorded.get("transports")
    if isinstance(old, list):
        new = now["transports"]
        found += [f"the transport {name} is installed now" for name in new if name not in old]
        found += [f"the transport {name} is not installed" for name in old if name not in new]
    sha256, seed = _sha256(program), str(recorded.get("hash_seed", ""))
    if sha256 and recorded.get("program_sha256") and sha256 != recorded["program_sha256"]:
        found.append(f"{program} has changed")
    if not seed.isdecimal():
        found.append(f"{HASH_SEED} was not set in the recording")
    elif seed != now["hash_seed"]:
        found.append(f"{HASH_SEED} is not {seed}")
    return found


def restored_environment(recorded: Mapping[str, Any]) -> dict[str, str]:
    """Return the environment of the machine, with what a program reads as in the recording.

    Args:
        recorded: What `surroundings` has returned for the recording.
    """
    own = {name for name in os.environ if name.startswith(_PREFIX) and name not in _KEPT}
    found = {name: value for name, value in os.environ.items() if name not in own}
    noted = recorded.get("environment")
    for name, value in noted.items() if isinstance(noted, dict) else ():
        if name in _NOTED:
            found[name] = str(value)
    seed = str(recorded.get("hash_seed", ""))
    if seed.isdecimal():
        found[HASH_SEED] = seed
    return found


@contextmanager
def restored(recorded: Mapping[str, Any]) -> Iterator[None]:
    """Have the arguments and the environment of a recording in this process for a while."""
    before = dict(os.environ), list(sys.argv)
    argv = recorded.get("argv")
    environment = restored_environment(recorded)
    # Python has read it at its start.
    environment.pop(HASH_SEED, None)
    if HASH_SEED in before[0]:
        environment[HASH_SEED] = before[0][HASH_SEED]
    _set_environment(environment)
    sys.argv[:] = [str(word) for word in argv] if isinstance(argv, list) and argv else before[1]
    try:
        yield
    finally:
        _set_environment(before[0])
        sys.argv[:] = before[1]


def _set_environment(environment: Mapping[str, str]) -> None:
    for name in os.environ.keys() - environment.keys():
        del os.environ[name]
    os.environ.update(environment)


def _version(name: str) -> str:
    with suppress(PackageNotFoundError):
        return version(name)
    return ""


def _sha256(file: str) -> str:
    """Return the digest of a file; empty if there is none."""
    with suppress(OSError, ValueError):
        return hashlib.sha256(Path(file).read_bytes()).hexdigest()
    return ""
