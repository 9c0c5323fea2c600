"""Types of message fields in the API reference: `uint8` instead of `Annotated[int, ...]`."""

import re
from typing import Any

from docutils.nodes import Text
from sphinx.addnodes import pending_xref

__all__ = ["replace", "simplified", "simplify_signature"]

_ANNOTATED = r"~?(?:\w+\.)?Annotated\["
_WIDTH = r"<Width\.\w+: '(\w+)'>"
_NUMBER = re.compile(rf"{_ANNOTATED}\w+, {_WIDTH}\]")
_BUFFER = re.compile(rf"{_ANNOTATED}bytes \| [^()]*?, [\w.~]*Numbers\(width={_WIDTH}\)\]")
_SIZED = re.compile(
    rf"{_ANNOTATED}((?:tuple\[[^()]*?\]|str)), [\w.~]*(Fixed|AtMost)\(size=(\d+)\)\]"
)


def simplified(text: str) -> str:
    """Return a text with short names of ROS types: `uint8`, `Buffer[uint8]`, `Fixed[..., 9]`."""
    text = _NUMBER.sub(r"\1", _BUFFER.sub(r"Buffer[\1]", text))
    return _SIZED.sub(r"\2[\1, \3]", text).replace("~", "")


def simplify_signature(
    app: Any, what: str, name: str, found: Any, options: Any, signature: Any, returns: Any
) -> Any:
    """Simplify the arguments of a message class. Sphinx calls it for each signature."""
    return (simplified(signature), returns) if signature and "Annotated" in signature else None


def replace(app: Any, page: Any) -> None:
    """Replace the type of each field by a short text. Sphinx calls it for each page."""
    for reference in list(page.findall(pending_xref)):
        target = str(reference.get("reftarget", ""))
        # The built-in `type` would lead to a field of that name.
        if "Annotated[" in target or (target == "type" and reference.get("refdomain") == "py"):
            reference.replace_self(Text(simplified(target)))
