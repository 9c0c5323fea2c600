"""Mermaid diagrams of a table (mermaid.js.org, State diagrams)."""

import re

from rosbase.fsm.table import Table

__all__ = ["draw"]

_PLAIN_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")

# Words of the diagram's own language, in any case, and the name of its outermost block.
_RESERVED = re.compile(
    "accdescr|acctitle|as|choice|class|classdef|click|default|direction|end|fork|hide|href|join"
    "|note|root|root_end|root_start|scale|state|statediagram|style",
    re.IGNORECASE,
)

# What would end a label or begin something else, as the entities that Mermaid reads.
_ENTITIES = {
    "#": "#35;",
    '"': "#quot;",
    "<": "#lt;",
    ">": "#gt;",
    ":": "#58;",
    ";": "#59;",
    "%": "#37;",
    "{": "#123;",
    "}": "#125;",
    "\\": "#92;",
}


def draw(table: Table) -> str:
    """Return a `stateDiagram-v2`; states whose names Mermaid cannot take get an alias."""
    names = _aliases(table.states)
    edges = table.edges()
    left = {source for source, _ in edges}
    lines = ["stateDiagram-v2"]
    lines += [
        f'    state "{_text(state)}" as {name}' for state, name in names.items() if state != name
    ]
    lines.append(f"    [*] --> {names[table.initial]}")
    for source, row in edges:
        reason = _text(row.reason)
        lines.append(
            f"    {names[source]} --> {names[row.target]}" + (f" : {reason}" if reason else "")
        )
    lines += [f"    {names[state]} --> [*]" for state in table.states if state not in left]
    return "\n".join(lines) + "\n"


def _aliases(states: tuple[str, ...]) -> dict[str, str]:
    """Return the name of each state in the diagram."""
    names: dict[str, str] = {}
    for state in states:
        # What a member of a string enumeration says of itself is another name.
        name, number = str.__str__(state), 0
        while not _can_be_taken(name) or name in names.values() or name in set(states) - {state}:
            number += 1
            name = f"s{number}"
        names[state] = name
    return names


def _can_be_taken(name: str) -> bool:
    return bool(_PLAIN_NAME.fullmatch(name)) and not _RESERVED.fullmatch(name)


def _text(words: str) -> str:
    return "".join(_ENTITIES.get(character, character) for character in " ".join(words.split()))
