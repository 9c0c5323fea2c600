"""The last seconds in memory."""

from pathlib import Path

from rosbase_mcap.channel_table import LATCHED, ChannelTable
from rosbase_mcap.reading import messages
from rosbase_mcap.ring import Ring
from support.open_chunks import open_chunk

BIG = 1 << 30


def saved(ring: Ring, path: Path) -> list[tuple[str, int]]:
    ring.save(path)
    with path.open("rb") as stream:
        return [(entry.channel.topic, entry.message.log_ns) for entry in messages(stream)]


def test_a_ring_keeps_the_last_seconds(tmp_path: Path) -> None:
    table = ChannelTable()
    number = table.add("/a", "std_msgs/msg/String", "string data", {})
    ring = Ring(table, {}, keep_ns=3, most_bytes=BIG)
    for stamp in range(10):
        ring.add(open_chunk(number, [stamp]))
    assert saved(ring, tmp_path / "one.mcap") == [("/a", stamp) for stamp in (6, 7, 8, 9)]
    # It goes on.
    ring.add(open_chunk(number, [10]))
    assert saved(ring, tmp_path / "two.mcap") == [("/a", stamp) for stamp in (7, 8, 9, 10)]


def test_a_ring_has_a_limit_in_bytes(tmp_path: Path) -> None:
    table = ChannelTable()
    number = table.add("/a", "std_msgs/msg/String", "string data", {})
    ring = Ring(table, {}, keep_ns=BIG, most_bytes=2500)
    ring.add(open_chunk(number, range(10), b"x" * 1000))
    assert saved(ring, tmp_path / "run.mcap") == [("/a", 8), ("/a", 9)]


def test_a_ring_keeps_messages_of_latched_topics(tmp_path: Path) -> None:
    table = ChannelTable()
    other = table.add("/a", "std_msgs/msg/String", "string data", {})
    static = table.add("/tf_static", "std_msgs/msg/String", "string data", {LATCHED: "true"})
    ring = Ring(table, {}, keep_ns=1, most_bytes=BIG)
    ring.add(open_chunk(static, [0]))
    ring.add(open_chunk(other, range(1, 10)))
    assert saved(ring, tmp_path / "run.mcap") == [("/tf_static", 0), ("/a", 8), ("/a", 9)]
