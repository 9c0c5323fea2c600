"""Lists of parameters by prefix and depth, by the rules of rclpy's `Node.list_parameters`."""

from collections.abc import Iterable, Sequence

__all__ = ["RECURSIVE", "list_names"]

RECURSIVE = 0
"""Depth of a list without a limit (rcl_interfaces/ListParameters)."""


def list_names(
    names: Iterable[str], prefixes: Sequence[str], depth: int
) -> tuple[list[str], list[str]]:
    """Return the names that are listed, and the prefixes that those have.

    A prefix is a name up to its last dot, such as `gains` for `gains.p`.

    Args:
        names: All names.
        prefixes: Names to list, each with everything below it; none for everything.
        depth: Greatest number of parts of a name, or behind one of the prefixes; 0 for any.
    """
    if depth < 0:
        return [], []
    listed = [name for name in names if _is_listed(name, prefixes, depth)]
    found = (name.rpartition(".") for name in listed)
    return listed, list(dict.fromkeys(prefix for prefix, dot, _ in found if dot))


def _is_listed(name: str, prefixes: Sequence[str], depth: int) -> bool:
    if not prefixes:
        return _is_within(name, depth)
    return any(
        name == prefix
        or (name.startswith(f"{prefix}.") and _is_within(name[len(prefix) + 1 :], depth))
        for prefix in prefixes
    )


def _is_within(name: str, depth: int) -> bool:
    return depth == RECURSIVE or name.count(".") < depth
