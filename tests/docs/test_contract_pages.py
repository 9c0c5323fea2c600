"""The pages about contracts have a section for each promise, and no other."""

import re

import pytest

from rosbase.testing import FramerContract, TransportCapabilities, TransportContract
from rosbase.testing.backend_kit.promises import PROMISES
from rosbase.testing.framer_promises import FRAMER_PROMISES
from rosbase.testing.promise import Promise
from rosbase.testing.transport_kit.author import TransportAuthor
from rosbase.testing.transport_kit.promised import promises_of
from rosbase.testing.transport_kit.promises import PREPARATIONS
from support.code_blocks import ROOT

CHECKED = promises_of(TransportContract)
PAGES = {
    "plugins/transport-contract": (*CHECKED, *PREPARATIONS),
    "plugins/framer-contract": FRAMER_PROMISES,
}
KIT = (ROOT / "docs/plugins/kit.md").read_text()


def sections_of(page: str) -> dict[str, list[str]]:
    """The paragraphs below each heading that can be a promise's."""
    _, *parts = re.split(r"^### (.+)$", (ROOT / f"docs/{page}.md").read_text(), flags=re.M)
    texts = [re.split(r"^## ", part, flags=re.M)[0] for part in parts[1::2]]
    paragraphs = [[" ".join(p.split()) for p in text.strip().split("\n\n")] for text in texts]
    return dict(zip(parts[::2], paragraphs, strict=True))


@pytest.mark.parametrize("page", PAGES)
def test_a_page_has_a_section_for_each_promise_in_their_order(page: str) -> None:
    assert list(sections_of(page)) == [promise.name for promise in PAGES[page]]
    assert {promise.page for promise in PAGES[page]} == {page}


@pytest.mark.parametrize("page", PAGES)
def test_a_section_begins_with_the_promise_and_says_more(page: str) -> None:
    sections = sections_of(page)
    for promise in PAGES[page]:
        sentence, *more = sections[promise.name]
        assert sentence == promise.sentence
        assert more


@pytest.mark.parametrize("promise", CHECKED, ids=lambda promise: promise.name)
def test_a_section_says_which_capability_the_promise_needs(promise: Promise) -> None:
    check = getattr(TransportContract, f"test_{promise.name.replace('-', '_')}")
    needs = " and ".join(f"`{need}`" for need in check.needs)
    said = [p for p in sections_of(promise.page)[promise.name] if p.startswith("Needs ")]
    assert said == ([f"Needs {needs}."] if needs else [])


def test_the_page_of_backends_has_each_promise_in_its_order() -> None:
    sections = sections_of("plugins/backend-contract")
    assert list(sections) == list(PROMISES)
    for name, promise in PROMISES.items():
        assert sections[name][0] == f"{promise.sentence}."


def test_the_page_of_the_kit_counts_the_promises() -> None:
    assert f"[{len(CHECKED)} of them](transport-contract.md)" in KIT
    assert f"[{len(FRAMER_PROMISES)} of them](framer-contract.md)" in KIT


def test_the_page_of_the_kit_names_every_capability_and_everything_an_author_may_write() -> None:
    names = [*TransportCapabilities.__annotations__, *TransportAuthor.__annotations__]
    names += [name for name in vars(TransportAuthor) if not name.startswith("_")]
    assert [name for name in names if f"`{name}" not in KIT] == []


def test_the_page_of_the_kit_shows_the_limits_as_they_are() -> None:
    for name in ("call_limit_s", "end_limit_s", "patience_s", "reconnect_limit_s", "cycles"):
        row = next(line for line in KIT.splitlines() if line.startswith(f"| `{name}`"))
        assert row.endswith(f"| {getattr(TransportAuthor, name):g} |")
    assert f"{TransportAuthor.memory_limit_bytes:,} |" in KIT
    assert f"{TransportAuthor.machine_examples}, {TransportAuthor.machine_steps} |" in KIT


def test_every_setting_of_a_framers_contract_is_on_the_page() -> None:
    names = [*FramerContract.__annotations__, "payloads", "make_framer", "encode"]
    assert [name for name in names if name not in KIT] == []
