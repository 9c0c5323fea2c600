"""The lifecycle as a drawing and as a table, made from `rosbase.lifecycle.TRANSITIONS`.

Only where the states stand on the drawing, and which arrows go around others, is said here.
"""

import math
from typing import NamedTuple

from rosbase import CallbackReturn, State
from rosbase.lifecycle import TRANSITIONS, Transition

__all__ = ["diagram", "table"]

WIDTH, HEIGHT = 970, 620
HALF_WIDTH, HALF_HEIGHT = 68, 19
PLACES = {
    State.ERRORPROCESSING: (470, 40),
    State.CONFIGURING: (290, 160),
    State.ACTIVATING: (650, 160),
    State.UNCONFIGURED: (115, 270),
    State.INACTIVE: (470, 270),
    State.ACTIVE: (825, 270),
    State.CLEANINGUP: (290, 380),
    State.DEACTIVATING: (650, 380),
    State.SHUTTINGDOWN: (470, 490),
    State.FINALIZED: (470, 590),
}
# Arrows that would run into something: through which points they are drawn towards.
BENDS = {
    5: ((130, 480),),
    7: ((810, 480),),
    52: ((-100, 490), (-100, 40)),
    60: ((60, 60),),
    61: ((1055, 40), (1055, 590)),
    62: ((1095, 30), (1095, 600)),
}
# Colour and dashes: what an arrow stands for is to be seen without colours too.
STYLES = {
    CallbackReturn.SUCCESS.label: ("#2e8b57", ""),
    CallbackReturn.FAILURE.label: ("#c77700", "7 4"),
    CallbackReturn.ERROR.label: ("#cc3344", "2 3"),
}
REQUEST = ("currentColor", "")


class Point(NamedTuple):
    """A place on the drawing."""

    x: float
    y: float


def table() -> str:
    """Every transition, in rcl's order, as a table in Markdown."""
    rows = [f"| {t.id} | `{t.label}` | {t.start.label} | {t.goal.label} |" for t in TRANSITIONS]
    return "\n".join(["| id | label | from | to |", "|---|---|---|---|", *rows]) + "\n"


def diagram() -> str:
    """Every state and every transition, as SVG to stand in a page."""
    parts = [
        '<div class="diagram">',
        f'<svg class="lifecycle" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" font-size="15"'
        ' text-anchor="middle" fill="currentColor" xmlns="http://www.w3.org/2000/svg">',
        "<title>The states of a lifecycle node and the transitions between them</title>",
        *(_head(name, colour) for name, (colour, _) in _styles().items()),
        *(_box(state) for state in PLACES),
        *(_arrow(transition) for transition in TRANSITIONS),
        *(_label(transition) for transition in TRANSITIONS if transition.is_public),
        *_legend(),
        "</svg></div>",
    ]
    return "\n".join(parts) + "\n"


def _styles() -> dict[str, tuple[str, str]]:
    return {"request": REQUEST, **STYLES}


def _head(name: str, colour: str) -> str:
    return (
        f'<marker id="{name}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8"'
        f' markerHeight="8" orient="auto"><path d="M0 0L8 4L0 8z" fill="{colour}"/></marker>'
    )


def _box(state: State) -> str:
    x, y = PLACES[state]
    thickness, corner = (2, 4) if state.is_primary else (1, HALF_HEIGHT)
    return (
        f'<rect x="{x - HALF_WIDTH}" y="{y - HALF_HEIGHT}" width="{2 * HALF_WIDTH}"'
        f' height="{2 * HALF_HEIGHT}" rx="{corner}" fill="none" stroke="currentColor"'
        f' stroke-width="{thickness}"/><text x="{x}" y="{y + 5}">{state.label}</text>'
    )


def _points(transition: Transition) -> list[Point]:
    """From edge to edge, with what the arrow is bent towards in between."""
    start, goal = Point(*PLACES[transition.start]), Point(*PLACES[transition.goal])
    bends = [Point(*place) for place in BENDS.get(transition.id, ())]
    if not bends:
        start, goal = _beside(transition, start, goal)
    first, last = (bends[0], bends[-1]) if bends else (goal, start)
    return [_edge(start, first), *bends, _edge(goal, last)]


def _arrow(transition: Transition) -> str:
    begin, *others = _points(transition)
    # A line, or the curves of Bezier with one and with two points to bend towards.
    path = f"M{_at(begin)}{'LQC'[len(others) - 1]}{' '.join(map(_at, others))}"
    name = "request" if transition.is_public else transition.label
    colour, dashes = _styles()[name]
    return (
        f'<path data-id="{transition.id}" d="{path}" fill="none" stroke="{colour}"'
        f' stroke-dasharray="{dashes}" stroke-width="1.5" marker-end="url(#{name})"/>'
    )


def _beside(transition: Transition, start: Point, goal: Point) -> tuple[Point, Point]:
    """Both ends, moved aside where another arrow joins the same two states."""
    ends = {transition.start, transition.goal}
    joining = [t for t in TRANSITIONS if {t.start, t.goal} == ends and t.id not in BENDS]
    if len(joining) == 1:
        return start, goal
    # Arrows of opposite directions move to opposite sides by themselves.
    same = [t for t in joining if t.start is transition.start]
    shift = 7.0 if same[0] is transition else -7.0
    length = math.dist(start, goal)
    dx, dy = -(goal.y - start.y) / length * shift, (goal.x - start.x) / length * shift
    return Point(start.x + dx, start.y + dy), Point(goal.x + dx, goal.y + dy)


def _edge(center: Point, towards: Point) -> Point:
    """Where the way from a state's middle to a point leaves its box."""
    dx, dy = towards.x - center.x, towards.y - center.y
    scale = min(
        HALF_WIDTH / abs(dx) if dx else math.inf, (HALF_HEIGHT + 2) / abs(dy) if dy else math.inf
    )
    return Point(center.x + dx * scale, center.y + dy * scale)


def _at(point: Point) -> str:
    return f"{point.x:.0f} {point.y:.0f}"


def _label(transition: Transition) -> str:
    points = _points(transition)
    # The middle of a curve with one bend is half of the bend and a quarter of each end.
    middle = [points[0], points[1], points[1], points[-1]] if len(points) == 3 else points
    x = sum(point.x for point in middle) / len(middle)
    y = sum(point.y for point in middle) / len(middle)
    text = f'<text x="{x:.0f}" y="{y:.0f}" font-weight="bold" font-size="13"'
    # First in the colour of the page, and broad, so that the line does not run through it.
    behind = 'stroke="var(--color-background-primary, white)" stroke-width="6"'
    return f"{text} {behind}>{transition.label}</text>{text}>{transition.label}</text>"


def _legend() -> list[str]:
    lines = []
    for row, (name, (colour, dashes)) in enumerate(_styles().items()):
        y = 540 + 22 * row
        words = name.removeprefix("transition_").upper() if row else "asked for"
        lines.append(
            f'<path d="M20 {y}H70" stroke="{colour}" stroke-dasharray="{dashes}"'
            f' stroke-width="1.5" marker-end="url(#{name})"/>'
            f'<text x="82" y="{y + 4}" text-anchor="start" font-size="13">{words}</text>'
        )
    return lines
