"""Conformance kit for framers: subclass `FramerContract` in a test."""

from collections.abc import Callable
from typing import Any, ClassVar

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from rosbase.framing import FrameEvent, Framer
from rosbase.testing import framer_checks, strategies
from rosbase.testing.framer_promises import (
    CHUNKING,
    ERRORS,
    FRAMER,
    JUNK,
    MEMORY,
    NOT_RAISING,
    PENDING,
    REASONS,
    RESET,
    SEPARATE,
    STAMP_ORDER,
    STAMPS,
    UNALTERED,
)
from rosbase.testing.promise import BrokenPromiseError, Promise
from rosbase.testing.seen import not_written, raised

__all__ = ["FramerContract"]

_MORE_PAYLOADS = 7
_TIMES = 30


def _check(promise: Promise) -> Callable[[Callable[[Any], None]], Callable[[Any], None]]:
    """Return a decorator that makes a test whose every failure names the promise."""

    def decorate(method: Callable[[Any], None]) -> Callable[[Any], None]:
        def run(self: Any) -> None:
            try:
                method(self)
            except BrokenPromiseError:
                raise
            except NotImplementedError as error:
                raise FRAMER.broken(not_written("a call of the framer", error)) from error
            except Exception as error:
                raise promise.broken(raised("the framer", error)) from error

        run.__name__, run.__qualname__ = method.__name__, method.__qualname__
        run.__doc__, run.__module__ = promise.sentence, method.__module__
        as_any: Any = run
        as_any.promise = promise
        return run

    return decorate


class _Guarded:
    """Framer whose return values of `feed` are checked."""

    def __init__(self, framer: Framer) -> None:
        self._framer = framer
        self.reset = framer.reset

    def __getattr__(self, name: str) -> Any:
        return getattr(self._framer, name)

    def feed(self, data: bytes, stamp_ns: int) -> list[FrameEvent]:
        events = self._framer.feed(data, stamp_ns)
        FRAMER.require(isinstance(events, list), f"feed gave {events!r}, which is no list")
        return events


class FramerContract:
    """All promises of a framer, one test each.

    Must define: `make_framer` and `encode`. May define: `payloads`, `junk` and the limits. Do not
    override the checks.
    """

    frames_lost_after_junk: ClassVar[int] = 1
    """Maximum number of frames lost or damaged after junk."""
    endless: ClassVar[bytes] = b"x" * 1_000
    """Bytes that are repeated and never end a frame."""
    memory_limit_bytes: ClassVar[int] = 200_000
    """Maximum memory of a framer, in bytes, while ten times as much is fed."""
    examples: ClassVar[int] = 100
    """Number of cases that hypothesis tries for each promise."""

    def make_framer(self) -> Framer:
        """Return a new framer."""
        raise NotImplementedError

    def encode(self, payload: bytes) -> bytes:
        """Return the bytes of one frame with that payload, delimiters included."""
        raise NotImplementedError

    def payloads(self) -> st.SearchStrategy[bytes]:
        """Return a strategy for payloads; by default text without line breaks."""
        return strategies.payloads()

    def junk(self) -> st.SearchStrategy[bytes]:
        """Return a strategy for bytes between frames, in addition to truncated frames."""
        return strategies.junk()

    @_check(FRAMER)
    def test_a_framer_is_made(self) -> None:
        self._encode(b"0")
        framer = self._made()
        missing = [name for name in ("feed", "reset") if not hasattr(framer, name)]
        FRAMER.require(not missing, f"{type(framer).__name__} has no {' and no '.join(missing)}")
        FRAMER.require(self._made() is not framer, "make_framer gave the same framer twice")

    @_check(UNALTERED)
    def test_frames_come_out_as_they_went_in(self) -> None:
        def check(several: list[bytes]) -> None:
            for payloads in (several, several * _TIMES):
                framer_checks.check_frames_come_out_as_they_went_in(
                    self._make, self._encode, payloads
                )

        self._try(self._several(), check)

    @_check(CHUNKING)
    def test_chunking_does_not_matter(self) -> None:
        self._try(
            self._chunks(),
            lambda chunks: framer_checks.check_chunking_does_not_matter(self._make, chunks),
        )

    @_check(JUNK)
    def test_junk_spoils_few_frames(self) -> None:
        # Fewer frames show nothing: none is lost, and no two are merged.
        several = self._several(self.frames_lost_after_junk + 2)
        self._try(
            st.tuples(self._disturbances(), several),
            lambda case: framer_checks.check_junk_spoils_few_frames(
                self._make, self._encode, case[0], case[1], self.frames_lost_after_junk
            ),
        )

    @_check(NOT_RAISING)
    def test_any_bytes_may_come(self) -> None:
        self._try(
            st.lists(st.binary(max_size=50)) | self._chunks(),
            lambda chunks: framer_checks.check_any_bytes_may_come(self._made, chunks),
        )

    @_check(MEMORY)
    def test_memory_is_bounded(self) -> None:
        limit = self.memory_limit_bytes
        framer_checks.check_memory_is_bounded(
            self._make, self.endless, limit_bytes=limit, fed_bytes=10 * limit
        )
        # A kept frame takes more memory than its bytes.
        framer_checks.check_memory_is_bounded_while_frames_come(
            self._make, self._encode, self._payload(), limit_bytes=limit, fed_bytes=2 * limit
        )

    @_check(ERRORS)
    def test_what_is_too_long_is_an_error(self) -> None:
        framer_checks.check_what_is_too_long_is_an_error(
            self._make,
            self._encode,
            self._far_too_long,
            self._payload(),
            self.frames_lost_after_junk,
        )

    @_check(STAMPS)
    def test_the_stamp_is_that_of_the_first_bytes(self) -> None:
        def check(case: tuple[bytes, bytes]) -> None:
            junk, payload = case
            framer_checks.check_stamp_is_that_of_the_first_bytes(self._make, self._encode, payload)
            for before in (junk, self._far_too_long):
                framer_checks.check_stamp_after_junk(
                    self._make, self._encode, before, payload, self.frames_lost_after_junk
                )

        payloads = self.payloads().filter(lambda payload: len(payload) > 2)
        self._try(st.tuples(self._disturbances(), payloads), check)

    @_check(STAMP_ORDER)
    def test_stamps_never_go_back(self) -> None:
        self._try(
            self._chunks(),
            lambda chunks: framer_checks.check_stamps_never_go_back(self._make, chunks),
        )

    @_check(RESET)
    def test_reset_forgets_a_begun_frame(self) -> None:
        def check(case: tuple[bytes, bytes]) -> None:
            begun, payload = case
            for before in (begun, self._far_too_long):
                framer_checks.check_reset_forgets_a_begun_frame(
                    self._make, self._encode, before, payload
                )

        self._try(st.tuples(self._begun(), self.payloads()), check)

    @_check(PENDING)
    def test_pending_bytes_are_those_since_the_last_end(self) -> None:
        has_it: list[bool] = []

        def check(payload: bytes) -> None:
            for endless in (self.endless, self._far_too_long):
                has_it.append(
                    framer_checks.check_pending_bytes(
                        self._make, self._encode, endless, payload, self.frames_lost_after_junk
                    )
                )

        self._try(self.payloads(), check)
        if not all(has_it):
            pytest.skip("the framer has no pending_bytes")

    @_check(REASONS)
    def test_an_error_has_a_reason_of_one_word(self) -> None:
        again = [self._far_too_long, self._encode(self._payload())] * _TIMES
        framer_checks.check_error_reasons(self._make, again)
        self._try(
            self._chunks(),
            lambda chunks: framer_checks.check_error_reasons(self._make, [*again[:1], *chunks]),
        )

    @_check(SEPARATE)
    def test_two_framers_share_nothing(self) -> None:
        self._try(
            st.tuples(self.payloads(), self.payloads()),
            lambda pair: framer_checks.check_two_framers_share_nothing(
                self._make, self._encode, *pair
            ),
        )

    @property
    def _far_too_long(self) -> bytes:
        return self.endless * (self.memory_limit_bytes // len(self.endless))

    def _payload(self) -> bytes:
        """Return a payload; any payload will do."""
        found: list[bytes] = []
        self._try(self.payloads(), found.append, examples=1)
        return found[0]

    def _several(self, least: int = 1) -> st.SearchStrategy[list[bytes]]:
        return st.lists(self.payloads(), min_size=least, max_size=least + _MORE_PAYLOADS)

    def _begun(self) -> st.SearchStrategy[bytes]:
        """Return truncated frames."""
        encoded = self.payloads().map(self._encode)
        return encoded.flatmap(
            lambda whole: st.integers(0, len(whole) - 1).map(lambda end: whole[:end])
        )

    def _disturbances(self) -> st.SearchStrategy[bytes]:
        return self.junk() | self._begun()

    def _chunks(self) -> st.SearchStrategy[list[bytes]]:
        stream = strategies.streams(self.payloads().map(self._encode))
        return stream.flatmap(strategies.chunkings)

    def _make(self) -> Framer:
        return _Guarded(self._made())

    def _made(self) -> Framer:
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

    def _try(
        self,
        cases: st.SearchStrategy[Any],
        check: Callable[[Any], object],
        examples: int | None = None,
    ) -> None:
        @settings(
            max_examples=examples or self.examples,
            deadline=None,
            database=None,
            # Variations of a failure do not help: the broken promise says what the check saw.
            phases=[Phase.explicit, Phase.generate, Phase.shrink],
            report_multiple_bugs=False,
            suppress_health_check=list(HealthCheck),
        )
        @given(cases)
        def tries(case: Any) -> None:
            check(case)

        tries()
