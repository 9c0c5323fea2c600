"""The state of the board as HTML for the panel. Pure.

Names and messages come from devices and programs, and the browser must not take them for tags. So
each text is escaped. viser also has Markdown, which runs what stands in braces as a script.
"""

from collections.abc import Iterable
from html import escape

from rosbase.text.printable import printable
from rosbase_view.drawing.figures import age, rate
from rosbase_view.web.health import Status
from rosbase_view.web.model import Picture
from rosbase_view.web.quantities import angles

__all__ = ["status_html"]

_COLOURS = {"OK": "#2b8a3e", "WARN": "#d9730d", "ERROR": "#c92a2a", "STALE": "#868e96"}
_FRAME = "padding: 0 1em 0.6em 1em; font-size: 0.85em; line-height: 1.5; overflow-wrap: anywhere"


def status_html(picture: Picture) -> str:
    """Return the lines above the plots."""
    lines = [_topic(picture), _attitude(picture), *map(_status, picture.statuses)]
    if picture.said is not None:
        colour = _COLOURS["ERROR" if picture.said.is_error else "OK"]
        lines.append(f'<span style="color: {colour}">{_text(picture.said.text)}</span>')
    return _frame(line for line in lines if line)


def _topic(picture: Picture) -> str:
    if not picture.topic:
        why = "no program publishes an Imu" if picture.has_programs else "no program runs"
        return _badge("STALE") + why
    if not picture.is_there:
        return _badge("STALE") + "nobody publishes it now; waiting for it"
    if not picture.is_answering:
        return _badge("STALE") + f"its program does not answer; last message: {age(picture.age_ns)}"
    if _is_silent(picture):
        return _badge("STALE") + f"silent for {age(picture.age_ns)}"
    return f"{rate(picture.rate_hz)}, last message: {age(picture.age_ns)}"


def _attitude(picture: Picture) -> str:
    if not picture.is_there:
        return ""
    if picture.rotation is None:
        # Whether it has one now, only the next message tells.
        return "no orientation" if picture.is_fresh else ""
    names = ("roll", "pitch", "yaw")
    found = zip(names, angles(picture.rotation), strict=True)
    return ", ".join(f"{name} {angle:.1f}°" for name, angle in found)


def _is_silent(picture: Picture) -> bool:
    return picture.position is None and picture.rate_hz == 0.0 and picture.age_ns is not None


def _status(status: Status) -> str:
    return f"{_badge(status.level)}{_text(status.name)}: {_text(status.message)}"


def _badge(level: str) -> str:
    """Return the level as a word too, for those who do not see its colour."""
    return f'<b style="color: {_COLOURS.get(level, _COLOURS["ERROR"])}">{level}</b> '


def _frame(lines: Iterable[str]) -> str:
    return f'<div style="{_FRAME}">{"<br>".join(lines)}</div>'


def _text(text: str) -> str:
    return escape(printable(text))
