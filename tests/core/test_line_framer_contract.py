"""`LineFramer` keeps the promises of a framer, whatever ends the lines."""

from typing import ClassVar

from rosbase.framing import LineFramer
from rosbase.testing import FramerContract


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
