"""Bags in SQLite, on the oldest Python."""

import sys
from typing import Any

import pytest

__all__ = ["LEAVES_OPEN", "with_reason"]

LEAVES_OPEN = sys.version_info < (3, 11)
"""The last apsw for Python 3.10, which rosbags uses, keeps a descriptor of each file in SQLite."""


def with_reason(value: Any, name: str) -> Any:
    """Returns a parameter of that name, which is left out where it leaves a file open."""
    is_left_out = LEAVES_OPEN and "SQLITE" in name.upper()
    marks = [pytest.mark.skipif(is_left_out, reason="apsw keeps a descriptor")]
    return pytest.param(value, id=name, marks=marks)
