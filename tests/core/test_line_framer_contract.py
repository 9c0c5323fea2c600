"""`LineFramer` keeps the promises of a framer, whatever ends the lines."""

from typing import ClassVar

import pytest
from hypothesis import strategies as st

from rosbase.framing import LineFramer
from rosbase.testing import FramerContract, strategies

pytestmark = pytest.mark.once


class TestLineFramer(FramerContract):
    ending: ClassVar[bytes] = b"\n"

    def make_framer(self) -> LineFramer:
        return LineFramer()

    def encode(self, payload: bytes) -> bytes:
        return payload + self.ending


class TestLineFramerWithBothEndings(TestLineFramer):
    ending = b"\r\n"


class TestLineFramerWithTheOldEnding(TestLineFramer):
    ending = b"\r"


class TestLineFramerOfShortLines(TestLineFramer):
    """Many of the streams are too long for it, anywhere."""

    endless = b"xxxxx"

    def make_framer(self) -> LineFramer:
        return LineFramer(12)

    def payloads(self) -> st.SearchStrategy[bytes]:
        return strategies.payloads(max_size=12)
