"""The log of child processes: their output, records, ends and restarts."""

import logging
from collections.abc import Iterable

from rosbase.logger import RosbaseLogger
from rosbase.processes.child import ChildProcess, Life, describe_end

__all__ = ["Journal"]


class Journal:
    """Writes about children into a log; each line has the name of its child."""

    def __init__(self, logger: RosbaseLogger) -> None:
        self.logger = logger
        """Logger for the lines. A manager puts its own logger here."""
        self.is_ending = False
        """Whether the program is ending. Then the ends of children are not logged."""

    def write(self, level: int, name: str, text: str, *, is_chosen: bool = False) -> None:
        """Write one line about a child.

        Args:
            level: A level of the standard library's `logging`.
            name: The child.
            text: The rest of the line.
            is_chosen: Whether the level of the child has let it pass, so that the level of the
                logger does not count.
        """
        line = f"{name}: {text}"
        if is_chosen:
            self.logger._pass_on(level, line)
            return
        methods = {
            logging.DEBUG: self.logger.debug,
            logging.WARNING: self.logger.warning,
            logging.ERROR: self.logger.error,
            logging.CRITICAL: self.logger.critical,
        }
        methods.get(level, self.logger.info)(line)

    def write_output(self, life: Life, lines: Iterable[str]) -> None:
        """Write the output of a child; log its tracebacks as errors."""
        for line in lines:
            # Python says with a traceback that it was interrupted, which is how a stop begins.
            is_error = life.tracebacks.is_part(line) and not (self.is_ending or life.was_asked)
            self.write(logging.ERROR if is_error else logging.INFO, life.child.name, line)

    def write_end(self, life: Life) -> None:
        """Write how a child has ended, once; and its other ended processes, when all have ended."""
        child, code = life.child, life.child.exit_code
        if code is not None and not life.is_reported:
            life.is_reported = True
            # What may be a stop of the whole program is judged by what has followed.
            was_ending = self.is_ending if life.may_be_a_stop else life.was_ending
            is_error = life.has_failed and not (was_ending or life.was_asked)
            level = logging.ERROR if is_error else logging.INFO
            why = life.why_not_started
            self.write(
                level, child.name, f"cannot be started: {why}" if why else describe_end(code)
            )
        if child.is_alive or life.is_settled:
            return
        life.is_settled = True
        if life.has_lost_guardian and not life.left:
            self.write(logging.ERROR, child.name, "its guardian is dead, so all of it was killed")
        if life.was_killed:
            self.write(logging.WARNING, child.name, "had to be killed")
        if life.left:
            self.write(logging.ERROR, child.name, f"could not be killed: {life.left}")

    def write_restart(self, child: ChildProcess, delay_s: float) -> None:
        """Write that a child is started again."""
        count = f"{child.restarts.in_a_row} of {child.restarts.policy.limit}"
        self.write(logging.WARNING, child.name, f"starting again in {delay_s:.1f} s ({count})")

    def write_last_end(self, child: ChildProcess) -> None:
        """Write that a child is not started again, if that matters."""
        if child.restarts.has_given_up:
            text = f"not started again: {child.restarts.in_a_row} in a row"
            self.write(logging.ERROR, child.name, text)
        if child.is_required:
            self.write(logging.ERROR, child.name, "is required, so the program ends")
