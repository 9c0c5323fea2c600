"""The floor of the prose: short sentences that begin with their subject.

No test can tell good English. This one finds sentences that are too long to be read once, and
openings that put a phrase in the place of a name.
"""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.code_blocks import PAGES as ALL_PAGES
from support.code_blocks import ROOT

MOST_WORDS = 30
MOST_EXCEPTIONS = 20
OPENINGS = re.compile(r"(?:Who|Whoever|Whose|What|That of|Those of|So many|Of)\b")
# Sentences that may stay as they are, by how they begin.
EXCEPTIONS: set[str] = {
    # Rows of the table of modules.
    "child processes: code,",
    "a complete transport for any device with a descriptor: code",
}

CODE = "code"
"""Stands for a span of code, so that it is one word."""

_SENTENCE_END = re.compile(r"(?<=[.!?])[\"')]*\s+")
_CLAUSE_END = re.compile(r"(?<=[.!?:;])[\"')]*\s+")
_ITEM = re.compile(r"\n(?=[ >]*(?:[-*+]|\d+[.)]|#+)\s)")
_MARK = re.compile(r"^(?:[ >]*(?:[-*+]|\d+[.)]|#+)\s+|[ >]*>\s*)+")


def prose_of(page: str) -> Iterator[str]:
    """Each paragraph, list item, heading and table cell, without its markup."""
    page = re.sub(r"^ *(`{3,}|:{3,}).*?^ *\1\s*?$", "\n", page, flags=re.S | re.M)
    page = re.sub(r"<!--.*?-->", "\n", page, flags=re.S)
    for block in re.split(r"\n\s*\n", page):
        for part in _ITEM.split(block):
            if part.lstrip().startswith("|"):
                rows = (row.strip().strip("|") for row in part.splitlines())
                texts = [cell for row in rows for cell in re.split(r"(?<!\\)\|", without_code(row))]
            else:
                texts = [without_code(_MARK.sub("", part))]
            yield from (" ".join(text.split()) for text in texts if re.search(r"\w", text))


def without_code(text: str) -> str:
    """The text with a word for each span of code, and of each link what is shown of it."""
    text = re.sub(r"\{[\w:]+\}(?=`)", "", text)
    text = re.sub(r"(`+)(?!`).+?(?<!`)\1(?!`)", CODE, text, flags=re.S)
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return re.sub(r"https?://\S+|(?<!\w)[*_]{1,2}|[*_]{1,2}(?!\w)", "", text)


def faults_of(page: str) -> list[str]:
    """The sentences that are too long, and the clauses that begin with what is no subject."""
    texts = list(prose_of(page))
    long = [s for text in texts for s in _SENTENCE_END.split(text) if len(s.split()) > MOST_WORDS]
    clauses = [clause for text in texts for clause in _CLAUSE_END.split(text)]
    return long + [c for c in clauses if OPENINGS.match(c) and not c.endswith("?")]


def excused(sentence: str) -> bool:
    return any(sentence.startswith(beginning) for beginning in EXCEPTIONS)


PAGES = [page for page in ALL_PAGES if page.name != "CHANGELOG.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_sentences_are_short_and_begin_with_their_subject(page: Path) -> None:
    faults = [fault for fault in faults_of(page.read_text()) if not excused(fault)]
    assert not faults, "\n".join(faults)


def test_exceptions_are_few_and_each_is_needed() -> None:
    assert len(EXCEPTIONS) <= MOST_EXCEPTIONS
    faults = [fault for page in PAGES for fault in faults_of(page.read_text())]
    for beginning in EXCEPTIONS:
        assert any(fault.startswith(beginning) for fault in faults), beginning


LONG = " ".join(["word"] * (MOST_WORDS + 1))
FITS = " ".join(["word"] * MOST_WORDS)


@pytest.mark.parametrize(
    "page",
    [
        *("Who reads this?! No.", "Whoever reads, writes.", "# What to know", "- What differs:"),
        *("That of ROS is used.", "Those of ROS are used.", "So many are read."),
        *("Good.\n  What comes is bad.", "| a | Good. What is in a cell |", "**What** is bold."),
        *("> What is quoted.", "Said: What comes.", "*Of* these, two.", "1. What is counted."),
        *("[What is a link](a.md).", f"{LONG}.", f"- Good.\n- {LONG}", f"| good | {LONG} |"),
        *(f"Good.\n\n{LONG}\n\nGood.", f"```text\ncode\n```\n{LONG}"),
    ],
)
def test_a_fault_is_found(page: str) -> None:
    assert faults_of(page)


@pytest.mark.parametrize(
    "page",
    [
        *("What is this?", "Look at what comes.", "Whole numbers.", "Whatever comes, is read."),
        *("Often.", "Whose is it?", "| `a | b. What c` | good |", f"A `What {LONG}`."),
        *(f"```text\nWhat comes. {LONG}\n```", f"<!-- What {LONG} -->", f"{FITS}. {FITS}."),
        *(f"- {FITS}\n- {FITS}", f"| {FITS} | {FITS} |\n| {FITS} |", f"# {FITS}\n\n{FITS}"),
        *(f"Read [a](https://{LONG.replace(' ', '/')}).", f":::{{include}} What {LONG}\n:::"),
    ],
)
def test_a_good_page_passes(page: str) -> None:
    assert not faults_of(page)
