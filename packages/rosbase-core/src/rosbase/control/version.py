"""The version of rosbase that a client is told."""

from functools import cache
from importlib.metadata import PackageNotFoundError, version

__all__ = ["rosbase_version"]


@cache
def rosbase_version() -> str:
    """Return the version of rosbase-core; empty if it is not installed, as in a bare checkout."""
    try:
        return version("rosbase-core")
    except PackageNotFoundError:
        return ""
