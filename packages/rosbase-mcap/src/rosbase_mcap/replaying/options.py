"""The options of a replay. Pure."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from attrs import asdict, field, frozen

from rosbase import ConfigurationError
from rosbase_mcap.replaying.run_file import RunFile

__all__ = ["ReplayOptions", "check_options"]

_NO_BEGINNING = {
    "ring": "it has only the last seconds of a run",
    "attach": "it was begun while the program ran",
}


def _names(topics: Iterable[str] | None) -> tuple[str, ...] | None:
    return None if topics is None else tuple(topics)


@frozen
class ReplayOptions:
    """The recording, its inputs, the rate and the part of a replay."""

    path: Path = field(converter=Path)
    """The recording."""
    topics: tuple[str, ...] | None = field(default=None, converter=_names)
    """Topics that come from the file, all others from the program: none stands for those that the
    program subscribes to. None replays every input of the recorded program."""
    rate: float | None = 1.0
    """Seconds of the recording for a second; None for as fast as possible."""
    start_ns: int = 0
    """From here on, in nanoseconds since the start, the replay keeps its rate and shows the log."""
    end_ns: int | None = None
    """End of the replay, in nanoseconds since the start; None for the end of the recording."""
    checks: bool = False
    """Whether what the program publishes is compared with the recording."""

    def to_text(self) -> str:
        """Return the options as a text."""
        return json.dumps({**asdict(self), "path": str(self.path)})

    @classmethod
    def from_text(cls, text: str) -> "ReplayOptions":
        """Return the options in a text that `to_text` has made."""
        values: dict[str, Any] = json.loads(text)
        return cls(**values)


def check_options(options: ReplayOptions, run: RunFile | None) -> None:
    """Check that a recording can be replayed in that way.

    Args:
        options: What the user wants.
        run: The recorded run; None if the file has no trace.

    Raises:
        ConfigurationError: It cannot; the message is one line, and says what can be done.
    """
    path = options.path
    if options.topics is not None:
        if options.checks:
            raise ConfigurationError("only a replay of all inputs is compared: leave out --topics")
        return
    if run is None:
        raise ConfigurationError(f"{path} has messages only, and no inputs: use --topics")
    why = _NO_BEGINNING.get(run.run.begins)
    if why is not None:
        raise ConfigurationError(f"{path} has no beginning: {why}; use --topics")
    if options.checks and run.lost:
        raise ConfigurationError(
            f"{path} cannot be compared: {run.lost} messages are missing in it"
        )
