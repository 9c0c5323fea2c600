"""`rosbase log`."""

from __future__ import annotations

from rosbase.cli.operate.reading import UsageError
from rosbase.control.questions.programs import ProgramQuestions
from rosbase.text.printable import log_line

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

__all__ = ["show_log"]

_LEVELS = {"debug": 10, "info": 20, "warn": 30, "warning": 30, "error": 40, "fatal": 50}
_NAMES = {10: "DEBUG", 20: "INFO", 30: "WARN", 40: "ERROR", 50: "FATAL"}


def show_log(given: Any) -> None:
    """Print records of the log in the format of ROS, oldest first."""
    level = _LEVELS.get(given.level.lower())
    if level is None:
        raise UsageError(f"--level: '{given.level}' is not one of debug, info, warn, error, fatal")
    questions = ProgramQuestions(given.program)
    for record in questions.log(level=level, last=given.lines, follow=given.follow):
        number = int(record["level"])
        name = _NAMES[max(10, min(50, number // 10 * 10))]
        stamp_s, stamp_ns = divmod(record["stamp_ns"], 1_000_000_000)
        text = "\n".join(map(log_line, record["text"].split("\n")))
        print(f"[{name}] [{stamp_s}.{stamp_ns:09d}] [{log_line(record['name'])}]: {text}",
              flush=given.follow)  # fmt: skip
