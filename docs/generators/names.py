"""Where a name of the API is documented: at the package that it is imported from."""

import re
from collections.abc import Iterable, Iterator
from enum import Enum
from importlib import import_module
from typing import Any

from sphinx.util.logging import getLogger

__all__ = ["complain_of_missing", "find_public"]


def find_public(app: Any, env: Any, reference: Any, shown: Any) -> Any:
    """Resolves `rosbase.State` of a signature as `rosbase.State`.

    Sphinx calls it for each reference that leads nowhere.
    """
    target = str(reference.get("reftarget", ""))
    domain = env.get_domain("py")
    for candidate in _candidates(target, domain.objects):
        if candidate in domain.objects:
            page = domain.objects[candidate].docname
            kind = reference.get("reftype", "class")
            return domain.resolve_xref(
                env, reference.get("refdoc", page), app.builder, kind, candidate, reference, shown
            )
    return None


def complain_of_missing(app: Any, env: Any) -> None:
    """Warns of each public name that no page shows, which ends the build.

    Sphinx calls it when all pages have been read.
    """
    domain = env.get_domain("py")
    for module in sorted(domain.modules):
        for name in _public(module):
            if name not in domain.objects:
                getLogger(__name__).warning(f"the API does not show {name}")


def _public(module: str) -> Iterator[str]:
    """The names that a module offers, and the members of enumerations."""
    loaded = import_module(module)
    for name in getattr(loaded, "__all__", ()):
        yield f"{module}.{name}"
        found = getattr(loaded, name)
        if isinstance(found, type) and issubclass(found, Enum):
            yield from (f"{module}.{name}.{member.name}" for member in found)


def _candidates(target: str, objects: Iterable[str]) -> list[str]:
    """The same name without one of the modules in its middle, or with those that define it."""
    parts = target.split(".")
    if len(parts) == 2:
        return [name for name in objects if re.fullmatch(rf"{parts[0]}(\.\w+)+\.{parts[1]}", name)]
    return [".".join(parts[:i] + parts[i + 1 :]) for i in range(len(parts) - 2, 0, -1)]
