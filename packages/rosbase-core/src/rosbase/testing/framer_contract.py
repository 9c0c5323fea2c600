"""The conformance kit for framers: subclass `FramerContract` in a test."""

from collections.abc import Callable
from typing import Any, ClassVar

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rosbase.framing import Framer
from rosbase.testing import framer_checks, strategies
from rosbase.testing.framer_promises import FRAMER
from rosbase.testing.seen import not_written

__all__ = ["FramerContract"]

_MORE_PAYLOADS = 7


class FramerContract:
    """Every promise of a framer, one test each.

    Must say: `make_framer` and `encode`. May say: `payloads` and the limits. The checks are not to
    be overridden.
    """

    frames_lost_after_junk: ClassVar[int] = 1
    """How many frames at most are lost or spoiled after junk."""
    endless: ClassVar[bytes] = b"x" * 1_000
    """What comes again and again and never ends a frame."""
    memory_limit_bytes: ClassVar[int] = 200_000
    """How much a framer may keep while ten times as much comes."""
    examples: ClassVar[int] = 100
    """How many cases hypothesis tries for each promise."""

    def make_framer(self) -> Framer:
        """A new framer."""
        raise NotImplementedError

    def encode(self, payload: bytes) -> bytes:
        """The bytes of one frame with that payload, delimiters included."""
        raise NotImplementedError

    def payloads(self) -> st.SearchStrategy[bytes]:
        """What a frame can carry; by default text without line breaks."""
        return strategies.payloads()

    def test_a_framer_is_made(self) -> None:
        """See `FRAMER`."""
        self._encode(b"0")
        framer = self._make()
        missing = [name for name in ("feed", "reset") if not hasattr(framer, name)]
        FRAMER.require(not missing, f"{type(framer).__name__} has no {' and no '.join(missing)}")
        FRAMER.require(self._make() is not framer, "make_framer gave the same framer twice")

    def test_frames_come_out_as_they_went_in(self) -> None:
        """See `UNALTERED`."""
        self._try(
            self._several(),
            lambda several: framer_checks.check_frames_come_out_as_they_went_in(
                self._make, self._encode, several
            ),
        )

    def test_chunking_does_not_matter(self) -> None:
        """See `CHUNKING`."""
        self._try(
            self._chunks(),
            lambda chunks: framer_checks.check_chunking_does_not_matter(self._make, chunks),
        )

    def test_junk_spoils_few_frames(self) -> None:
        """See `JUNK`."""
        # With fewer of them there is nothing to be seen: none lost, or no two made one.
        several = self._several(self.frames_lost_after_junk + 2)
        self._try(
            st.tuples(strategies.junk(), several),
            lambda case: framer_checks.check_junk_spoils_few_frames(
                self._make, self._encode, case[0], case[1], self.frames_lost_after_junk
            ),
        )

    def test_any_bytes_may_come(self) -> None:
        """See `NOT_RAISING`."""
        self._try(
            st.lists(st.binary(max_size=50)) | self._chunks(),
            lambda chunks: framer_checks.check_any_bytes_may_come(self._make, chunks),
        )

    def test_memory_is_bounded(self) -> None:
        """See `MEMORY`."""
        framer_checks.check_memory_is_bounded(
            self._make,
            self.endless,
            limit_bytes=self.memory_limit_bytes,
            fed_bytes=10 * self.memory_limit_bytes,
        )

    def test_the_stamp_is_that_of_the_first_bytes(self) -> None:
        """See `STAMPS`."""
        self._try(
            self.payloads().filter(lambda payload: len(payload) > 1),
            lambda payload: framer_checks.check_stamp_is_that_of_the_first_bytes(
                self._make, self._encode, payload
            ),
        )

    def test_stamps_never_go_back(self) -> None:
        """See `STAMP_ORDER`."""
        self._try(
            self._chunks(),
            lambda chunks: framer_checks.check_stamps_never_go_back(self._make, chunks),
        )

    def test_reset_forgets_a_begun_frame(self) -> None:
        """See `RESET`."""
        self._try(
            st.tuples(self.payloads(), self.payloads()),
            lambda pair: framer_checks.check_reset_forgets_a_begun_frame(
                self._make, self._encode, *pair
            ),
        )

    def test_an_error_has_a_reason_of_one_word(self) -> None:
        """See `REASONS`."""
        endless = self.endless * (self.memory_limit_bytes // len(self.endless))
        self._try(
            self._chunks(),
            lambda chunks: framer_checks.check_error_reasons(self._make, [endless, *chunks]),
        )

    def test_two_framers_share_nothing(self) -> None:
        """See `SEPARATE`."""
        self._try(
            st.tuples(self.payloads(), self.payloads()),
            lambda pair: framer_checks.check_two_framers_share_nothing(
                self._make, self._encode, *pair
            ),
        )

    def _several(self, least: int = 1) -> st.SearchStrategy[list[bytes]]:
        return st.lists(self.payloads(), min_size=least, max_size=least + _MORE_PAYLOADS)

    def _chunks(self) -> st.SearchStrategy[list[bytes]]:
        stream = strategies.streams(self.payloads().map(self._encode))
        return stream.flatmap(strategies.chunkings)

    def _make(self) -> Framer:
        try:
            framer = self.make_framer()
        except NotImplementedError as error:
            raise FRAMER.broken(not_written("make_framer", error)) from error
        FRAMER.require(framer is not None, "make_framer gave None: does it return what it makes?")
        return framer

    def _encode(self, payload: bytes) -> bytes:
        try:
            encoded = self.encode(payload)
        except NotImplementedError as error:
            raise FRAMER.broken(not_written("encode", error)) from error
        FRAMER.require(isinstance(encoded, bytes), f"encode({payload!r}) gave {encoded!r}")
        return encoded

    def _try(self, cases: st.SearchStrategy[Any], check: Callable[[Any], None]) -> None:
        @settings(
            max_examples=self.examples,
            deadline=None,
            database=None,
            # What varies beside a failure is no help: the broken promise says what was seen.
            phases=[Phase.explicit, Phase.generate, Phase.shrink],
            suppress_health_check=list(HealthCheck),
        )
        @given(cases)
        def tries(case: Any) -> None:
            check(case)

        tries()
