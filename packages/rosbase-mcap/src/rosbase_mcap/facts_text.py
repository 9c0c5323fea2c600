"""The contents of a file, as lines for people. Pure."""

from datetime import datetime, timezone

from rosbase_mcap.channel_table import ORIGIN, OUTSIDE
from rosbase_mcap.summary import Summary
from rosbase_mcap.traces import is_trace

__all__ = ["facts_lines", "span_text"]


def facts_lines(summary: Summary, *, size_bytes: int, profile: str) -> list[str]:
    """Return the lines that `rosbase info` prints.

    Args:
        summary: What is in the file.
        size_bytes: Its length.
        profile: Conventions that it follows.
    """
    lines = [
        f"size:      {_size(size_bytes)}",
        f"profile:   {profile or 'none'}",
        f"messages:  {summary.messages}",
    ]
    if summary.start_ns is not None and summary.end_ns is not None:
        lines += [
            f"start:     {_date(summary.start_ns)}",
            f"end:       {_date(summary.end_ns)}",
            f"duration:  {span_text(summary.end_ns - summary.start_ns)}",
        ]
    kinds = sorted({chunk.compression or "none" for chunk in summary.chunks})
    lines.append(f"chunks:    {len(summary.chunks)} (compression: {', '.join(kinds) or 'none'})")
    names = [index.attachment for index in summary.attachments]
    has_inputs = any(is_trace(one) for one in names)
    lines.append(f"replay:    {'all inputs' if has_inputs else 'topics only'}")
    others = [one.name for one in names if not is_trace(one)]
    if others:
        lines.append(f"attached:  {', '.join(others)}")
    return [*lines, *_topics(summary)]


def span_text(duration_ns: int) -> str:
    """Return a time span, such as `2 h 05 min 03.2 s`."""
    seconds = duration_ns / 1e9
    minutes, hours = int(seconds // 60) % 60, int(seconds // 3600)
    if hours:
        return f"{hours} h {minutes:02} min {seconds % 60:04.1f} s"
    if minutes:
        return f"{minutes} min {seconds % 60:04.1f} s"
    return f"{seconds:.3f} s"


def _topics(summary: Summary) -> list[str]:
    rows = []
    for channel in sorted(summary.channels.values(), key=lambda channel: channel.topic):
        schema = summary.schemas.get(channel.schema_id)
        count = summary.counts[channel.id]
        type_name = schema.name if schema else "no schema"
        # Of a topic that both the program and others publish, each has a channel.
        origin = "from outside" if channel.metadata.get(ORIGIN) == OUTSIDE else ""
        rows.append((channel.topic, type_name, str(count), origin))
    if not rows:
        return ["topics:    none"]
    name, kind, count = (max(len(row[at]) for row in rows) for at in range(3))
    return ["topics:"] + [
        f"  {row[0]:{name}}  {row[1]:{kind}}  {row[2]:>{count}}  {row[3]}".rstrip() for row in rows
    ]


def _size(size_bytes: int) -> str:
    for unit, limit in (("GB", 1_000_000_000), ("MB", 1_000_000), ("KB", 1_000)):
        if size_bytes >= limit:
            return f"{size_bytes / limit:.1f} {unit}"
    return f"{size_bytes} B"


def _date(stamp_ns: int) -> str:
    try:
        date = datetime.fromtimestamp(stamp_ns // 1_000_000_000, timezone.utc)
    except (OverflowError, ValueError):
        # A file may say anything.
        return f"{stamp_ns} ns"
    return f"{date:%Y-%m-%d %H:%M:%S}.{stamp_ns % 1_000_000_000 // 1_000_000:03} UTC"
