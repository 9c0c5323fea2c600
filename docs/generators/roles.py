"""The four roles and the flow of data between them as a drawing, for light and dark pages."""

from typing import NamedTuple

from rosbase import BaseAgent, BaseHandlers, BaseManager, BaseNode

__all__ = ["ROLES", "diagram", "picture"]

WIDTH, HEIGHT = 480, 440
# A page says what is light and dark; a file of its own follows the system.
_ON_A_PAGE = "display:block;max-width:34rem;width:100%;height:auto;margin:1rem auto"
_ALONE = "svg{color:#1f2328}@media(prefers-color-scheme:dark){svg{color:#e6edf3}}"
_SMALL = 'font-size="13.5"'


class Box(NamedTuple):
    """A box of the drawing: what it is called, and what it does."""

    x: int
    y: int
    width: int
    height: int
    title: str
    code: str
    lines: tuple[str, ...]
    colour: str


ROLES = (
    Box(
        *(10, 104, 460, 326, "Manager", BaseManager.__name__),
        (
            f"builds the others, calls {BaseHandlers.handle.__name__}() at",
            "a fixed rate, and stops everything cleanly",
        ),
        "#8a63d2",
    ),
    Box(
        *(28, 190, 424, 70, "Node", BaseNode.__name__),
        ("publishes, subscribes, keeps the last messages",),
        "#2f81f7",
    ),
    Box(
        *(28, 328, 208, 86, "Handlers", BaseHandlers.__name__),
        (f"{BaseHandlers.handle.__name__}() at each tick:", "decides what to do next"),
        "#d9822b",
    ),
    Box(
        *(304, 328, 148, 86, "Agent", BaseAgent.__name__),
        ("computes;", "has no topics"),
        "#2e9e5b",
    ),
)
WORLD = Box(
    *(10, 8, 460, 54, "Devices, child processes, ROS 2", ""),
    ("topics go through a backend: local (no ROS) or ros2",),
    "currentColor",
)


class Arrow(NamedTuple):
    """An arrow of the drawing, with what flows along it."""

    x: int
    y: int
    to_x: int
    to_y: int
    label: str
    label_x: int
    label_y: int
    anchor: str


ARROWS = (
    Arrow(350, 62, 350, 188, "messages", 342, 88, "end"),
    Arrow(380, 190, 380, 64, "commands", 388, 88, "start"),
    Arrow(92, 260, 92, 326, "last messages", 100, 288, "start"),
    Arrow(212, 328, 212, 262, "what to publish", 220, 310, "start"),
    Arrow(236, 362, 302, 362, "inputs", 270, 354, "middle"),
    Arrow(304, 386, 238, 386, "result", 270, 404, "middle"),
)


def diagram() -> str:
    """Return SVG to stand in a page, in the colours of its text."""
    return _drawing(f'class="roles" style="{_ON_A_PAGE}"')


def picture() -> str:
    """Return SVG that is a file of its own."""
    return _drawing(f'width="{WIDTH + 80}"', f"<style>{_ALONE}</style>")


def _drawing(attributes: str, style: str = "") -> str:
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img"'
        f' font-family="system-ui, sans-serif" fill="currentColor" {attributes}>',
        "<title>The four roles, and the data that flows between them</title>",
        *([style] if style else []),
        '<marker id="roles-head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8"'
        ' markerHeight="8" orient="auto"><path d="M0 0L8 4L0 8z"/></marker>',
        *(_box(box) for box in (WORLD, *ROLES)),
        *(_arrow(arrow) for arrow in ARROWS),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _box(box: Box) -> str:
    x, y = box.x + 14, box.y + 23
    code = (
        f'<tspan dx="8" font-size="12" font-weight="normal" opacity="0.75"'
        f' font-family="ui-monospace, monospace">{box.code}</tspan>'
    )
    lines = "".join(
        f'<text x="{x}" y="{y + 20 * number}" {_SMALL}>{line}</text>'
        for number, line in enumerate(box.lines, start=1)
    )
    return (
        f'<rect x="{box.x}" y="{box.y}" width="{box.width}" height="{box.height}" rx="7"'
        f' fill="{box.colour}" fill-opacity="0.07" stroke="{box.colour}" stroke-width="1.6"/>'
        f'<text x="{x}" y="{y}" font-size="16" font-weight="bold">{box.title}{code}</text>{lines}'
    )


def _arrow(arrow: Arrow) -> str:
    return (
        f'<path d="M{arrow.x} {arrow.y}L{arrow.to_x} {arrow.to_y}" stroke="currentColor"'
        ' stroke-width="1.6" fill="none" marker-end="url(#roles-head)"/>'
        f'<text x="{arrow.label_x}" y="{arrow.label_y}" text-anchor="{arrow.anchor}"'
        f' {_SMALL} font-style="italic">{arrow.label}</text>'
    )
