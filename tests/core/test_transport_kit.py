"""The kit finds what is wrong: each mutant breaks one promise, and that one is named."""

import os
from collections.abc import Iterator

import pytest

from rosbase.testing import BrokenPromiseError, TransportContract
from rosbase.testing.transport_kit.flood import Flood
from rosbase.testing.transport_kit.promised import promises_of
from rosbase.testing.transport_kit.promises import PREPARATIONS
from support.fifo import FifoContract
from support.mutants import LEAKED, MUTANTS, RELEASE, Mutant

pytestmark = pytest.mark.usefixtures("same_cases")

CHECKS = {promise.name: promise for promise in promises_of(TransportContract)}
PATIENCE = {"call_limit_s": 3.0, "end_limit_s": 2.0, "patience_s": 3.0, "reconnect_limit_s": 4.0}


@pytest.fixture(autouse=True)
def nothing_stays_behind() -> Iterator[None]:
    RELEASE.clear()
    yield
    RELEASE.set()
    while LEAKED:
        os.close(LEAKED.pop())


@pytest.mark.once
@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: f"{mutant.promise}-{mutant.name}")
def test_a_mutant_is_rejected_with_the_promise_that_it_breaks(mutant: Mutant) -> None:
    said = rejection(mutant, mutant.contract())
    if mutant.seen not in said:
        # On a busy machine an impatient check may see first that something takes its time.
        patient = type("Patient", (mutant.contract,), PATIENCE)
        said = rejection(mutant, patient())
    first, promised, seen, more, *_ = said.splitlines()
    assert first == f"broken promise: {mutant.promise}"
    assert more.endswith(f"plugins/transport-contract.md#{mutant.promise}")
    assert mutant.seen in said, seen
    assert len(promised) > len("  promised: ")


def rejection(mutant: Mutant, contract: FifoContract) -> str:
    """What the check of its promise says of the mutant, which it must reject."""
    # What an author has not finished is found by whichever check comes first.
    check = mutant.promise if mutant.promise in CHECKS else "health-counts-what-arrives"
    contract.setup_method()
    try:
        with pytest.raises(BrokenPromiseError) as rejected:
            getattr(contract, f"test_{check.replace('-', '_')}")()
    finally:
        contract.teardown_method()
    return str(rejected.value)


def test_no_check_is_without_a_mutant() -> None:
    names = {*CHECKS, *(promise.name for promise in PREPARATIONS)}
    assert names == {mutant.promise for mutant in MUTANTS}


def test_a_stop_that_hangs_does_not_hang_the_check_of_health() -> None:
    promise = "calls-are-bounded-while-on-frame-hangs"
    contract = next(mutant for mutant in MUTANTS if mutant.promise == promise).contract()
    contract.setup_method()
    try:
        contract.test_health_never_waits()
        assert not RELEASE.is_set()
    finally:
        contract.teardown_method()


def test_a_flood_over_a_link_in_this_process_costs_memory_for_each_payload() -> None:
    sent: list[bytes] = []
    flood = Flood(sent.append, [b"x" * 100])
    flood.wait_for(1_000, 5.0)
    flood.end()
    assert sent[0] == sent[1]
    assert sent[0] is not sent[1]
