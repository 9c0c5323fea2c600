"""Sizes of files as people write them."""

import re

__all__ = ["byte_count"]

_UNITS = {"": 1, "k": 10**3, "m": 10**6, "g": 10**9, "ki": 2**10, "mi": 2**20, "gi": 2**30}
_SIZE = re.compile(r"(\d+(?:\.\d+)?)\s*([kmg]i?)?b?", re.I)


def byte_count(size: str | int) -> int:
    """Return the bytes of a size such as `10 MB`, `1.5 GiB` or a number.

    Raises:
        ValueError: It is no size.
    """
    found = _SIZE.fullmatch(str(size).strip())
    if found is None:
        raise ValueError(f"{size!r} is no size of a file, such as '10 MB' or '512 KiB'")
    return int(float(found[1]) * _UNITS[(found[2] or "").lower()])
