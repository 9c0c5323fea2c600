"""For pytest, which loads it by itself: a broken promise is shown as its four lines."""

from collections.abc import Generator
from typing import Any

import pytest

from rosbase.testing.promise import BrokenPromiseError

__all__ = ["pytest_runtest_makereport"]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    call: "pytest.CallInfo[None]",
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Leaves out the kit's own code, which the author of a plugin cannot mend."""
    report = yield
    error: Any = call.excinfo.value if call.excinfo is not None else None
    if isinstance(error, BrokenPromiseError):
        report.longrepr = str(error)
    return report
