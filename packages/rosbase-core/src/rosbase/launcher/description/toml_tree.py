"""Read TOML into a tree with lines."""

import re

from rosbase.launcher.description.toml_lines import lines_of
from rosbase.launcher.description.tree import Faults, Value, as_tree
from rosbase.text.toml import parse_toml

__all__ = ["read_toml"]

_PLACE = re.compile(r" \(at line (\d+), column \d+\)$")


def read_toml(text: str, faults: Faults) -> Value | None:
    """Return the tree of a file; None after noting why there is none."""
    try:
        return as_tree(parse_toml(text), 0, lines_of(text))
    except RecursionError:
        faults.add(0, "nested too deeply")
    except ValueError as error:
        place = _PLACE.search(str(error))
        faults.add(int(place[1]) if place else 0, f"not TOML: {_PLACE.sub('', str(error))}")
    return None
