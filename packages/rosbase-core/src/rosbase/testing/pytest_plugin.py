"""pytest plugin, loaded automatically: show a broken promise as its four lines."""

from collections.abc import Generator
from typing import Any

import pytest

from rosbase.testing.promise import BrokenPromiseError, Promise
from rosbase.testing.seen import raised

__all__ = ["pytest_runtest_makereport"]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
    call: "pytest.CallInfo[None]",
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Omit the kit's own code, which the author of a plugin cannot fix.

    An unexpected error breaks the promise of the check too, and keeps its traceback.
    """
    report = yield
    error: Any = call.excinfo.value if call.excinfo is not None else None
    promise: Promise | None = getattr(getattr(item, "function", None), "promise", None)
    if isinstance(error, BrokenPromiseError):
        report.longrepr = str(error)
    elif promise is not None and isinstance(error, Exception):
        report.longrepr = f"{promise.broken(raised('a call', error))}\n\n{report.longrepr}"
    return report
