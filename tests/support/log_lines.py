"""Lines of the log, as the console has them."""

import re

_TIME = re.compile(r"(?m)^(\[[A-Z]+\] )\[\d+\.\d{9}\] ")


def without_times(text: str) -> str:
    """The lines without the time that each begins with, as in `[INFO] [boss]: ready`."""
    return _TIME.sub(r"\1", text)
