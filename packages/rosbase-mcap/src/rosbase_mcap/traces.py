"""The trace of a run and what is known of it, as attachments and metadata of MCAP. Pure.

They are no messages of ROS, so they are no messages of the file: `ros2 bag` refuses channels of
another encoding, and every reader leaves attachments and metadata alone.
"""

import json
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from attrs import field, frozen

from rosbase.entries.sink import EndFacts, RunFacts
from rosbase.entries.trace import TraceBlock
from rosbase_mcap.errors import McapError
from rosbase_mcap.records import Attachment, Metadata

__all__ = [
    "BROKEN",
    "END",
    "RUN",
    "Run",
    "RunEnd",
    "blocks_of",
    "end_metadata",
    "is_trace",
    "read_end",
    "read_run",
    "run_metadata",
    "trace_attachment",
]

RUN, END = "rosbase:run", "rosbase:end"
"""Names of the metadata: at the start of each file, and at the end of the last."""
BROKEN = "rosbase:broken"
"""Name of the metadata that says why a recording ends before its program."""
_TRACE = "rosbase/trace/"
_MEDIA_TYPE = "application/vnd.rosbase.trace"
_FORMAT = 1


@frozen
class Run:
    """Facts of a run, in each of its files."""

    id: str
    """The same in all files of a recording, and in no other."""
    part: int
    """Number of the file in the recording, from 0 up."""
    begins: str
    """`start`, or `ring` and `attach` for a recording without a beginning."""
    topics: frozenset[str]
    """Full names of the topics that were chosen; empty for all."""
    facts: RunFacts


@frozen
class RunEnd:
    """Facts of the end of a run, in the last of its files."""

    facts: EndFacts
    more: Mapping[str, Any] = field(factory=dict)


def trace_attachment(block: TraceBlock, number: int, start_date_ns: int) -> Attachment:
    """Return a block of a trace as the attachment of that number.

    Args:
        block: The block.
        number: How many blocks were written before, in all files.
        start_date_ns: Date of the start of the run, in nanoseconds since 1970.
    """
    date_ns = max(0, start_date_ns + block.start_ns)
    data = block.to_bytes(start_date_ns)
    return Attachment(date_ns, 0, f"{_TRACE}{number:06}", _MEDIA_TYPE, data)


def is_trace(attachment: Attachment) -> bool:
    """Return whether an attachment is a block of a trace."""
    return attachment.name.startswith(_TRACE)


def blocks_of(attachments: Iterable[Attachment]) -> Iterator[TraceBlock]:
    """Yield the blocks of a trace in their order, up to the first one that is missing or damaged.

    Args:
        attachments: The attachments of all files of a recording, in order.
    """
    expected = 0
    for attachment in attachments:
        if not is_trace(attachment):
            continue
        if attachment.name != f"{_TRACE}{expected:06}":
            return
        try:
            block = TraceBlock.from_bytes(attachment.data)
        except ValueError:
            return
        expected += 1
        yield block


def run_metadata(run: Run) -> Metadata:
    """Return what is known of a run, for the start of a file."""
    values = {
        "format": _FORMAT,
        "run": run.id,
        "part": run.part,
        "begins": run.begins,
        "topics": sorted(run.topics),
        "start_date_ns": run.facts.start_date_ns,
        "start_monotonic_ns": run.facts.start_monotonic_ns,
    }
    return _metadata(RUN, {**values, **{f"fact:{k}": v for k, v in run.facts.more.items()}})


def read_run(metadata: Metadata) -> Run:
    """Return what the start of a file says.

    Raises:
        McapError: It is damaged, or from a later version of rosbase-mcap.
    """
    values = _values(metadata)
    if values.get("format") != _FORMAT:
        raise McapError("a later version of rosbase-mcap has made this recording")
    try:
        facts = RunFacts(
            int(values["start_date_ns"]),
            int(values["start_monotonic_ns"]),
            {key.removeprefix("fact:"): v for key, v in values.items() if key.startswith("fact:")},
        )
        names = str(values["run"]), int(values["part"]), str(values["begins"])
        return Run(*names, frozenset(values["topics"]), facts)
    except (KeyError, TypeError, ValueError):
        raise McapError(f"the metadata {RUN} is damaged") from None


def end_metadata(end: RunEnd) -> Metadata:
    """Return what is known of the end of a run, for the end of its last file."""
    values = {
        "entries": end.facts.entries,
        "ended_by": end.facts.ended_by,
        "spoiled": list(end.facts.spoiled),
    }
    return _metadata(END, {**values, **end.more})


def read_end(metadata: Metadata) -> RunEnd:
    """Return what the end of a file says.

    Raises:
        McapError: It is damaged.
    """
    values = _values(metadata)
    try:
        facts = EndFacts(
            int(values.pop("entries")), str(values.pop("ended_by")), tuple(values.pop("spoiled"))
        )
        return RunEnd(facts, values)
    except (KeyError, TypeError, ValueError):
        raise McapError(f"the metadata {END} is damaged") from None


def _metadata(name: str, values: Mapping[str, Any]) -> Metadata:
    return Metadata(name, {key: json.dumps(value) for key, value in values.items()})


def _values(metadata: Metadata) -> dict[str, Any]:
    try:
        return {key: json.loads(value) for key, value in metadata.values.items()}
    except ValueError:
        raise McapError(f"the metadata {metadata.name} is damaged") from None
