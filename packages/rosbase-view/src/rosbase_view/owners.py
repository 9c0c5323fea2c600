"""Names of the programs whose topics or nodes have one name. Pure."""

from collections import Counter
from collections.abc import Collection, Mapping

__all__ = ["owners"]


def owners(
    keys: Collection[tuple[str, int]], programs: Mapping[int, str]
) -> dict[tuple[str, int], str]:
    """Return the program of each key whose name others have too.

    Args:
        keys: Names of topics or nodes, each with a pid.
        programs: Name of the program of each pid.

    Returns:
        The name of the program; with its pid, if programs of one name have the topic or the node.
    """
    names = Counter(name for name, _ in keys)
    named = {key: programs.get(key[1], "").lstrip("/") for key in keys if names[key[0]] > 1}
    alike = Counter((key[0], program) for key, program in named.items())
    return {
        key: program if program and alike[key[0], program] == 1 else f"{program} [{key[1]}]".strip()
        for key, program in named.items()
    }
