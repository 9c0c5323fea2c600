"""Where a recording is, and the keys that move it. Pure."""

from datetime import datetime

from attrs import evolve

from rosbase_view.drawing.bars import filled
from rosbase_view.drawing.figures import playing_time
from rosbase_view.drawing.glyphs import Glyphs
from rosbase_view.drawing.lines import Ink, Line, Span, line
from rosbase_view.reports import Position
from rosbase_view.source import Playback

__all__ = ["HINTS", "draw_timeline", "press"]

HINTS = (("space", "play"), (",.<>", "seek"), ("-+", "speed"))
_NS = 1_000_000_000
# textual names the keys so.
_SEEKS_S = {"comma": -5, "full_stop": 5, "less_than_sign": -60, "greater_than_sign": 60}
_FASTER = {"minus": 0.5, "plus": 2.0, "equals_sign": 2.0}
_LEAST_RATE, _MOST_RATE = 1 / 16, 64.0


def draw_timeline(position: Position, width: int, glyphs: Glyphs) -> Line:
    """Return a line with the time in the recording, a bar, the speed, and the date."""
    passed_ns, whole_ns = position.now_ns - position.begin_ns, position.end_ns - position.begin_ns
    state = "playing" if position.is_playing else "paused "
    begin = f" {state}  {playing_time(passed_ns)} / {playing_time(whole_ns)}  "
    seconds, rest_ns = divmod(position.now_ns, _NS)
    date = f"{datetime.fromtimestamp(seconds):%Y-%m-%d %H:%M:%S}.{rest_ns // 100_000_000}"
    end = f"  x{position.rate:g}  {date} "
    room = width - len(begin) - len(end) - 2
    share = passed_ns / whole_ns if whole_ns > 0 else 1.0
    bar = filled(share, room, glyphs) if room > 0 else ""
    return line(
        Span(begin, Ink.TITLE), "[" if bar else "", Span(bar, Ink.DRAWING), "]" if bar else "", end
    )


def press(key: str, position: Position, playback: Playback) -> Position | None:
    """Move the recording; return where it is now, or None for a key that does not move it."""
    if key == "space":
        (playback.pause if position.is_playing else playback.play)()
        return evolve(position, is_playing=not position.is_playing)
    if key in _SEEKS_S:
        wanted_ns = position.now_ns + _SEEKS_S[key] * _NS
        playback.seek(wanted_ns)
        return evolve(position, now_ns=max(position.begin_ns, min(position.end_ns, wanted_ns)))
    if key in _FASTER:
        rate = max(_LEAST_RATE, min(_MOST_RATE, position.rate * _FASTER[key]))
        playback.set_rate(rate)
        return evolve(position, rate=rate)
    return None
