"""Where a name of the API is documented: at the package that it is imported from."""

from typing import Any

__all__ = ["find_public"]


def find_public(app: Any, env: Any, reference: Any, shown: Any) -> Any:
    """Resolves `rosbase.lifecycle.table.State` of a signature as `rosbase.lifecycle.State`.

    Sphinx calls it for each reference that leads nowhere.
    """
    target = str(reference.get("reftarget", ""))
    domain = env.get_domain("py")
    for candidate in _shorter(target):
        if candidate in domain.objects:
            page = domain.objects[candidate].docname
            kind = reference.get("reftype", "class")
            return domain.resolve_xref(
                env, reference.get("refdoc", page), app.builder, kind, candidate, reference, shown
            )
    return None


def _shorter(target: str) -> list[str]:
    """The same name without one of the modules in its middle."""
    parts = target.split(".")
    return [".".join(parts[:i] + parts[i + 1 :]) for i in range(len(parts) - 2, 0, -1)]
