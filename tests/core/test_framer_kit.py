"""The kit finds what is wrong with a framer, and names the promise."""

import pytest

from rosbase.framing import Framer
from rosbase.testing import BrokenPromiseError, FramerContract
from rosbase.testing.framer_promises import FRAMER_PROMISES
from support.mutants.framers import (
    FRAMER_MUTANTS,
    FramerMutant,
    GivingNothing,
    Remembering,
    Unwritten,
    of,
)

pytestmark = pytest.mark.usefixtures("same_cases")

NAMES = {promise.name for promise in FRAMER_PROMISES}


def name_of(mutant: FramerMutant) -> str:
    return f"{mutant.promise}-{mutant.contract.__name__}"


@pytest.mark.once
@pytest.mark.parametrize("mutant", FRAMER_MUTANTS, ids=name_of)
def test_a_framer_is_rejected_with_the_promise_that_it_breaks(mutant: FramerMutant) -> None:
    with pytest.raises(BrokenPromiseError) as rejected:
        getattr(mutant.contract(), f"test_{mutant.promise.replace('-', '_')}")()
    assert str(rejected.value).startswith(f"broken promise: {mutant.promise}\n")
    assert mutant.seen in str(rejected.value)


def test_no_check_of_a_framer_is_without_a_mutant() -> None:
    checks = [name for name in vars(FramerContract) if name.startswith("test_")]
    assert {name.removeprefix("test_").replace("_", "-") for name in checks} == NAMES
    assert {mutant.promise for mutant in FRAMER_MUTANTS} == NAMES


def test_a_framer_need_not_say_how_many_bytes_are_pending() -> None:
    with pytest.raises(pytest.skip.Exception, match="has no pending_bytes"):
        of(Remembering)().test_pending_bytes_are_those_since_the_last_end()


@pytest.mark.parametrize("name", sorted(NAMES - {"a-framer-is-made"}))
@pytest.mark.parametrize(
    ("framer", "seen"),
    [(Unwritten, "step 3: cut frames"), (GivingNothing, "gave None")],
)
def test_what_is_not_written_yet_is_named_by_every_check(
    framer: type[Framer], seen: str, name: str
) -> None:
    with pytest.raises(BrokenPromiseError) as rejected:
        getattr(of(framer)(), f"test_{name.replace('-', '_')}")()
    assert seen in str(rejected.value)
    assert len(str(rejected.value).splitlines()) == 4
