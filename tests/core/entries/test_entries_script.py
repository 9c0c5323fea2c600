"""A trace, as bytes and back, and the entries that it has."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosbase.entries.kinds import HAS_PAYLOAD, INTS, IS_NOTE, Kind
from rosbase.entries.script import Entry, read_entries
from rosbase.entries.trace import Trace, TraceBlock

NUMBERS = st.integers(-(2**63), 2**63 - 1)
TEXTS = st.text(max_size=5).map(str.encode)
FACTS = st.sampled_from([b"null", b"true", b'{"a":[1,2.5]}'])


@st.composite
def notes(draw: st.DrawFn) -> tuple[Kind, tuple[int, ...], bytes | None]:
    kind = draw(st.sampled_from(sorted(set(Kind) - {Kind.BEGIN, Kind.END})))
    numbers = tuple(draw(NUMBERS) for _ in range(INTS[kind]))
    content = FACTS if kind is Kind.FACT else TEXTS
    return kind, numbers, draw(content) if kind in HAS_PAYLOAD else None


@st.composite
def runs(draw: st.DrawFn) -> list[TraceBlock]:
    """A whole run, in blocks that were taken at any time."""
    trace = Trace()
    trace.begin(Kind.BEGIN, 0)
    blocks = []
    for kind, numbers, payload in draw(st.lists(notes(), max_size=40)):
        note = trace.note if kind in IS_NOTE else trace.begin
        note(kind, *numbers, payload=payload)
        if draw(st.booleans()):
            blocks.append(trace.take())
    trace.begin(Kind.END, 7)
    return [*blocks, trace.take()]


def script(blocks: list[TraceBlock]) -> list[Entry]:
    return list(read_entries(blocks))


@given(runs())
def test_a_block_comes_back_equal_from_its_bytes(blocks: list[TraceBlock]) -> None:
    assert [TraceBlock.from_bytes(block.to_bytes()) for block in blocks] == blocks


@given(runs())
def test_every_note_is_in_the_script_once_and_in_order(blocks: list[TraceBlock]) -> None:
    entries = script(blocks)
    codes = [block.ints[place] for block in blocks for place in block.starts]
    assert [entry.kind for entry in entries] == codes
    assert [entry.number for entry in entries] == list(range(len(entries)))
    seen = sum(
        1
        + len(entry.notes.mono)
        + len(entry.notes.date)
        + len(entry.notes.slept)
        + len(entry.notes.facts)
        + len(entry.notes.created)
        for entry in entries
    )
    spoils = sum(bool(entry.notes.spoiled) for entry in entries)
    total = sum(len(block.ints) for block in blocks)
    assert total >= seen + spoils
    assert (entries[0].kind, entries[-1].kind) == (Kind.BEGIN, Kind.END)


@given(runs(), st.data())
def test_a_prefix_of_a_trace_has_a_prefix_of_its_entries(
    blocks: list[TraceBlock], data: st.DataObject
) -> None:
    count = data.draw(st.integers(0, len(blocks)))
    entries, prefix = script(blocks), script(blocks[:count])
    assert prefix == entries[: len(prefix)]
    begun = sum(len(list(block.starts)) for block in blocks[:count])
    assert len(prefix) == (begun if count == len(blocks) else max(0, begun - 1))


@given(runs(), st.data())
def test_a_script_ends_where_a_block_is_missing(
    blocks: list[TraceBlock], data: st.DataObject
) -> None:
    gap = data.draw(st.integers(0, len(blocks) - 1))
    if not list(blocks[gap].starts):
        return
    entries = script(blocks[:gap] + blocks[gap + 1 :])
    assert entries == script(blocks[:gap])


def test_an_entry_has_what_was_noted_while_it_ran() -> None:
    trace = Trace()
    trace.begin(Kind.BEGIN, 0)
    trace.note(Kind.NEW, 1, 0, payload=b"blink")
    trace.begin(Kind.TIMER, 5, 0)
    trace.note(Kind.READ_MONO, 6)
    trace.note(Kind.READ_MONO, 7)
    trace.note(Kind.READ_DATE, 8)
    trace.note(Kind.FACT, payload=b'{"frames":3}')
    assert trace.number == 1
    trace.begin(Kind.END, 9)
    build, timer, _ = script([trace.take()])
    assert [(c.what, c.number, c.text) for c in build.notes.created] == [(1, 0, "blink")]
    assert (timer.t_ns, timer.ints) == (5, (5, 0))
    assert list(timer.notes.mono) == [6, 7]
    assert list(timer.notes.date) == [8]
    assert list(timer.notes.facts) == [{"frames": 3}]


def test_a_payload_is_made_only_when_it_is_written() -> None:
    made: list[bytes] = []

    def make() -> bytes:
        made.append(b"late")
        return made[0]

    trace = Trace()
    trace.begin(Kind.BEGIN, 0)
    trace.begin(Kind.PUBLISH, 1, 0, payload=make)
    trace.begin(Kind.END, 2)
    block = trace.take()
    assert made == []
    assert script([TraceBlock.from_bytes(block.to_bytes())])[1].payload == b"late"


@pytest.mark.parametrize("damage", ["cut", "other", "body"])
def test_damaged_bytes_are_an_error(damage: str) -> None:
    trace = Trace()
    trace.begin(Kind.BEGIN, 0)
    data = trace.take().to_bytes()
    damaged = {"cut": data[:-3], "other": b"MCAP" + data[4:], "body": data[:44] + b"xxxx"}[damage]
    with pytest.raises(ValueError, match="trace"):
        TraceBlock.from_bytes(damaged)


def test_the_header_has_the_date_of_the_first_entry() -> None:
    trace = Trace()
    trace.begin(Kind.BEGIN, 40)
    data = trace.take().to_bytes(1_700_000_000_000_000_000)
    assert int.from_bytes(data[16:24], "little") == 1_700_000_000_000_000_040


def test_every_kind_says_how_many_numbers_it_has() -> None:
    assert set(INTS) == set(Kind)
    assert all(INTS[kind] >= 1 for kind in set(Kind) - IS_NOTE), "t is the first"
