"""Find the entry points of installed distributions, including damaged ones."""

import re
from collections.abc import Iterable
from importlib.metadata import Distribution, EntryPoint, distributions

from attrs import frozen

from rosbase.text.printable import one_line

__all__ = ["CORE", "Candidate", "find_candidates"]

CORE = "rosbase-core"
"""Distribution of the core's own plugins."""


@frozen
class Candidate:
    """An entry point that claims to be a plugin."""

    name: str
    """Name of the entry point."""
    distribution: str
    """Installed package that it belongs to."""
    version: str
    entry: EntryPoint | None
    """Object to load; None if the metadata cannot be read."""
    damage: str = ""
    """Fault of the metadata, in one line."""

    @property
    def full_name(self) -> str:
        """Distribution and entry point: two packages may use the same name."""
        return f"{self.distribution}:{self.name}"

    @property
    def package(self) -> str:
        """Package that is imported to load it; empty if the metadata cannot be read."""
        return self.entry.module.partition(".")[0] if self.entry else ""

    @property
    def is_core(self) -> bool:
        """Whether it is part of the core."""
        return self.distribution == CORE


def find_candidates(group: str, path: list[str] | None = None) -> list[Candidate]:
    """Return the entry points of the group, by distribution and name.

    Args:
        group: The entry-point group.
        path: Folders to search; by default Python's.
    """
    found: dict[str, list[Candidate]] = {}
    for distribution in _distributions(path):
        # Of two of one name, the first on the path is the one that Python imports.
        key = _key_of(distribution)
        if key not in found:
            found[key] = list(_candidates_of(distribution, group))
    return sorted((c for part in found.values() for c in part), key=_order)


def _distributions(path: list[str] | None) -> Iterable[Distribution]:
    """Return the installed distributions, as far as they can be listed."""
    listed = iter(distributions() if path is None else distributions(path=path))
    while True:
        try:
            yield next(listed)
        except (StopIteration, OSError):
            return


def _order(candidate: Candidate) -> tuple[str, str]:
    return candidate.distribution, candidate.name


def _candidates_of(distribution: Distribution, group: str) -> Iterable[Candidate]:
    try:
        if f"[{group}]" not in (distribution.read_text("entry_points.txt") or ""):
            return
        version = distribution.version or "?"
        entries = [entry for entry in distribution.entry_points if entry.group == group]
    except Exception as error:
        damage = f"its metadata cannot be read: {one_line(repr(error))}"
        yield Candidate("?", _name_of(distribution), "?", None, damage)
        return
    name = _name_of(distribution)
    for entry in entries:
        yield Candidate(entry.name, name, version, entry)


def _key_of(distribution: Distribution) -> str:
    """Return the name in its normal form; from its folder, without reading its metadata.

    An environment may hold hundreds of distributions, and to read one takes a millisecond.
    """
    name = _folder_name_of(distribution) or _name_of(distribution)
    return re.sub(r"[-_.]+", "-", name).lower()


def _name_of(distribution: Distribution) -> str:
    try:
        name = distribution.metadata["Name"]
    except Exception:
        name = None
    # A folder without its METADATA file still has a name of its own.
    return name or _folder_name_of(distribution) or "unknown"


def _folder_name_of(distribution: Distribution) -> str:
    """Return `a_b` for the folder `a_b-1.0.dist-info` or `a_b.egg-info`; else an empty text."""
    folder = getattr(distribution, "_path", None)
    if folder is None:
        return ""
    return str(folder.name).removesuffix(".egg-info").removesuffix(".dist-info").partition("-")[0]
