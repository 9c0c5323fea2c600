"""What the tests of the core have in common."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

# Whether chance finds what is wrong with a mutant is decided once, not in each run.
settings.register_profile("mutants", settings.get_profile("rosbase"), derandomize=True)


@pytest.fixture
def same_cases() -> Iterator[None]:
    """Has hypothesis try the same cases in each run."""
    settings.load_profile("mutants")
    yield
    settings.load_profile("rosbase")


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder that stands for site-packages."""
    monkeypatch.syspath_prepend(tmp_path)
    before = set(sys.modules)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    yield tmp_path
    for name in set(sys.modules) - before:
        del sys.modules[name]
