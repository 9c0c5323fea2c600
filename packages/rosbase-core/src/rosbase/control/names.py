"""Names that users give: find what is meant among what runs, or say what may have been. Pure."""

from __future__ import annotations

from rosbase.errors import ControlError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

__all__ = ["absolute", "ambiguous", "full_type", "is_hidden", "one_of", "similar", "unknown"]

# Below this likeness, a name is a guess.
_NEAR = 0.7


def absolute(name: str) -> str:
    """Return the name with the slash in front that people leave out."""
    return name if name.startswith("/") else f"/{name}"


def full_type(name: str, kind: str = "msg") -> str:
    """Return the type with the part that people leave out: `std_msgs/msg/String`."""
    package, _, rest = name.partition("/")
    return name if "/" in rest or not rest else f"{package}/{kind}/{rest}"


def is_hidden(name: str) -> bool:
    """Return whether a name is hidden, as in ROS: a part of it begins with an underscore."""
    return "/_" in name


def similar(name: str, known: Iterable[str]) -> list[str]:
    """Return up to three known names that may have been meant."""
    # Only after a mistake.
    from difflib import get_close_matches

    names = sorted(set(known))
    last = name.rpartition("/")[2]
    ends = [k for k in names if last and k.rpartition("/")[2] == last]
    near = [n for form in (name, absolute(name)) for n in get_close_matches(form, names, 3, _NEAR)]
    return list(dict.fromkeys(ends + near))[:3]


def unknown(kind: str, name: str, known: Iterable[str]) -> ControlError:
    """Return the error for a name that nothing has."""
    names = sorted(set(known))
    near = similar(name, names)
    if near:
        hint = f"; did you mean {' or '.join(near)}?"
    elif names:
        hint = f"; there are: {', '.join(names[:10])}{', ...' if len(names) > 10 else ''}"
    else:
        hint = f"; there is no {kind} at all"
    return ControlError(f"no {kind} {name}{hint}", "unknown", near)


def ambiguous(kind: str, name: str, programs: Iterable[str]) -> ControlError:
    """Return the error for a name that several programs have."""
    who = list(programs)
    text = f"{kind} {name} is in {len(who)} programs: {', '.join(who)}; choose one with --program"
    return ControlError(text, "ambiguous", who)


def one_of(kind: str, name: str, owners: Mapping[str, Iterable[int]], labels: Mapping[int, str],
           ) -> tuple[str, int]:  # fmt: skip
    """Return the full name and the process that has it.

    Args:
        kind: What it is, for errors.
        name: As the user gave it, with or without the slash in front.
        owners: The processes that have each name.
        labels: How to write each process in an error.

    Raises:
        ControlError: No process has it, or several have.
    """
    full = name if name in owners else absolute(name)
    if full not in owners:
        raise unknown(kind, name, owners)
    pids = sorted(set(owners[full]))
    if len(pids) > 1:
        raise ambiguous(kind, full, [labels.get(pid, str(pid)) for pid in pids])
    return full, pids[0]
