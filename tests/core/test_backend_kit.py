"""The kit for backends finds what is wrong with one, and says so by the promise that it breaks."""

import os
import re
from collections.abc import Iterator
from contextlib import suppress

import pytest

from rosbase.clock import SystemClock
from rosbase.contracts import backend as contract
from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.node_connection import NodeConnection
from rosbase.local import Bus, LocalBackend
from rosbase.testing import BackendCapabilities, BackendContract, BrokenPromiseError
from rosbase.testing.backend_kit.promises import PROMISES
from support.backend_mutants import LEFT_OPEN, MUTANTS, PATIENCE_S

CHECKS = {name for name in dir(BackendContract) if name.startswith("test_")}
EVERYTHING = BackendCapabilities(
    delivers_in_process=True,
    several_per_process=True,
    takes_a_clock=True,
    has_log_handler=True,
    has_services=True,
    has_taps=True,
)


@pytest.fixture(autouse=True)
def own_world(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Keeps what a broken backend leaves behind from the next one."""
    bus = Bus()
    monkeypatch.setattr("rosbase.local.backend.process_bus", lambda: bus)
    yield
    while LEFT_OPEN:
        os.close(LEFT_OPEN.pop())


def check_of(promise: str) -> str:
    return f"test_{promise.replace('-', '_')}"


def run(
    promise: str,
    kind: type[Backend] = LocalBackend,
    declared: BackendCapabilities = EVERYTHING,
) -> None:
    """Runs the check of one promise on backends of that kind, as pytest does."""

    class Kit(BackendContract):
        patience_s = PATIENCE_S
        capabilities = declared

        def make_backend(self, options: BackendOptions) -> Backend:
            return kind(options)  # type: ignore[call-arg, arg-type]  # each mutant takes options

    kit = Kit()
    kit.setup_method()
    try:
        getattr(kit, check_of(promise))()
    finally:
        with suppress(BrokenPromiseError):
            kit.teardown_method()


def test_every_check_has_a_promise_of_its_name_and_a_backend_that_breaks_it() -> None:
    assert {check_of(promise) for promise in PROMISES} == CHECKS
    assert MUTANTS.keys() == PROMISES.keys()


@pytest.mark.parametrize(
    ("promise", "mutant"),
    [(promise, mutant) for promise, found in MUTANTS.items() for mutant in found],
    ids=lambda value: value if isinstance(value, str) else value.__name__,
)
def test_a_backend_that_breaks_a_promise_is_rejected_by_that_name(
    promise: str, mutant: type[Backend]
) -> None:
    with pytest.raises(BrokenPromiseError) as caught:
        run(promise, mutant)
    first, *_, seen, more = str(caught.value).splitlines()
    assert first == f"broken promise: {promise}"
    assert re.match(r"  seen: +\S", seen)
    assert more.endswith(f"docs/plugins/backend-contract.md#{promise}")


@pytest.mark.parametrize(
    ("promise", "capability"),
    [
        ("takes-a-clock", "takes_a_clock"),
        ("log-handler-raises-nothing", "has_log_handler"),
        ("backends-hear-each-other", "several_per_process"),
        ("last-words-outlive-the-backend", "several_per_process"),
        ("closing-leaves-others-alone", "several_per_process"),
        ("two-may-call-each-other", "several_per_process"),
        ("services-answer", "has_services"),
    ],
)
def test_what_a_backend_does_not_say_that_it_can_is_skipped_with_the_reason(
    promise: str, capability: str
) -> None:
    with pytest.raises(pytest.skip.Exception, match=rf"\({capability}=True\) is not declared"):
        run(promise, declared=BackendCapabilities())


def test_a_backend_that_says_what_was_not_declared_is_rejected() -> None:
    with pytest.raises(BrokenPromiseError, match="it is True, and declared as False"):
        run("delivers-in-process", declared=BackendCapabilities())


def test_a_contract_without_a_factory_is_a_broken_promise_that_says_so() -> None:
    kit = BackendContract()
    kit.setup_method()
    with pytest.raises(BrokenPromiseError, match="BackendContract has no make_backend"):
        kit.test_names_are_full()


def test_an_unfinished_backend_is_told_what_is_missing() -> None:
    with pytest.raises(BrokenPromiseError, match=r"Unfinished .*abstract.*create_publisher"):
        run("names-are-full", MUTANTS["opens"][0])


def listed(head: str) -> set[str]:
    """The names that the text of the contract has under that head."""
    assert contract.__doc__
    text = re.search(rf"{head}[^:]*: ([^.]*)\.", contract.__doc__)
    assert text, head
    return set(re.findall(r"`(\w+)`", text[1]))


def test_the_lists_of_the_contract_are_what_the_class_has() -> None:
    methods = {name: lambda self, *args: None for name in Backend.__abstractmethods__}
    finished = type("Finished", (Backend,), methods)
    members = {*vars(Backend), *vars(NodeConnection)}
    public = {name for name in members if not name.startswith("_")}
    assert listed("Must implement") == Backend.__abstractmethods__
    assert listed("May implement") == public - Backend.__abstractmethods__
    attributes = set(vars(finished(SystemClock(), "kit")))
    assert listed("May set") | listed("Never override") == attributes
    assert not listed("May set") & listed("Never override")
