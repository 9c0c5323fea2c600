"""Strategies for hypothesis: valid and invalid data of devices."""

import json
from itertools import pairwise

from hypothesis import strategies as st

__all__ = ["chunkings", "imu_samples", "junk", "payloads", "streams"]

_NUMBERS = st.floats(-1_000, 1_000).map(lambda number: round(number, 6))
_LONGEST_SAMPLE = 250
_VECTORS = st.fixed_dictionaries(dict.fromkeys("xyz", _NUMBERS))


def imu_samples() -> st.SearchStrategy[bytes]:
    """Return a strategy for IMU samples for the default mapping: JSON, on one line."""
    samples = st.fixed_dictionaries(
        {"angular_velocity": _VECTORS, "linear_acceleration": _VECTORS},
        optional={"header": st.fixed_dictionaries({"stamp": _stamps()})},
    )
    return samples.map(lambda sample: json.dumps(sample).encode())


def payloads(max_size: int = _LONGEST_SAMPLE) -> st.SearchStrategy[bytes]:
    """Return a strategy for lines: text without line breaks and without outer blanks."""
    texts = st.text(
        st.characters(exclude_categories=["Cc", "Cs", "Zs", "Zl", "Zp"]),
        min_size=1,
        max_size=max_size // 4,
    )
    encoded = texts.map(str.encode)
    return encoded | imu_samples() if max_size >= _LONGEST_SAMPLE else encoded


def junk(max_size: int = 100) -> st.SearchStrategy[bytes]:
    """Return a strategy for the data of a disturbed line or of a device that boots."""
    pieces = st.sampled_from([b"\r", b"\n", b"\x00", b" ", b"\xff", b"{", b'"', b"ets Jul 29 2019"])
    return st.lists(pieces | st.binary(max_size=8), max_size=max_size // 8).map(b"".join)


def streams(frames: st.SearchStrategy[bytes]) -> st.SearchStrategy[bytes]:
    """Return a strategy for encoded frames with junk and parts of frames between them."""
    parts = frames.flatmap(lambda frame: st.integers(0, len(frame)).map(lambda n: frame[:n]))
    return st.lists(frames | parts | junk(), max_size=8).map(b"".join)


@st.composite
def chunkings(draw: st.DrawFn, data: bytes) -> list[bytes]:
    """Return a strategy for the same bytes, cut anywhere."""
    cuts = draw(st.lists(st.integers(0, len(data)), max_size=20))
    edges = [0, *sorted(cuts), len(data)]
    return [data[start:end] for start, end in pairwise(edges)]


def _stamps() -> st.SearchStrategy[dict[str, int]]:
    return st.fixed_dictionaries(
        {"sec": st.integers(0, 2**31 - 1), "nanosec": st.integers(0, 999_999_999)}
    )
