"""The order in which programs start: who waits for whom, and circles in it."""

from collections.abc import Collection, Mapping

__all__ = ["circles", "in_order"]


def circles(after: Mapping[str, Collection[str]]) -> list[list[str]]:
    """Return the circles of programs that wait for each other, each once, from its first member.

    Args:
        after: For each program, the ones that it waits for.
    """
    found: list[list[str]] = []
    done: set[str] = set()
    for first in after:
        _search(first, [], done, after, found)
    return found


def _search(
    start: str,
    before: list[str],
    done: set[str],
    after: Mapping[str, Collection[str]],
    found: list[list[str]],
) -> None:
    # Without recursion: a file may have a long chain.
    path = [*before, start]
    stack = [iter(after.get(start, ()))] if start not in done else []
    while stack:
        following = next(stack[-1], None)
        if following is None:
            stack.pop()
            done.add(path.pop())
        elif following in path:
            found.append(path[path.index(following) :])
        elif following not in done and following in after:
            path.append(following)
            stack.append(iter(after[following]))


def in_order(after: Mapping[str, Collection[str]]) -> list[str]:
    """Return the programs so that each comes behind the ones that it waits for.

    Apart from that, they keep the order of the mapping. Programs of a circle come last.
    """
    ordered: dict[str, None] = {}
    waiting = list(after)
    while waiting:
        ready = [
            name
            for name in waiting
            if all(other in ordered or other not in after for other in after[name])
        ]
        if not ready:
            return [*ordered, *waiting]
        # One at a time, so that a program comes as early as the order of the file allows.
        ordered[ready[0]] = None
        waiting.remove(ready[0])
    return list(ordered)
