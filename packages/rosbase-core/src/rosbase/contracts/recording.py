"""The recording of a program: its options, and what a plugin implements to make one."""

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from attrs import asdict, field, frozen

from rosbase.errors import ConfigurationError

if TYPE_CHECKING:
    from rosbase.contracts.backend import Backend
    from rosbase.entries.sink import RecordingSink
    from rosbase.logger import RosbaseLogger

__all__ = ["RecordOptions", "Recording"]


def _not_negative(instance: object, attribute: object, value: float | None) -> None:
    if value is not None and not (value >= 0 and math.isfinite(value)):
        raise ConfigurationError(
            f"{getattr(attribute, 'name', attribute)} of a recording is not {value!r}"
        )


def _texts(values: Iterable[str]) -> tuple[str, ...]:
    # One alone is a mistake that is easily made, and has one meaning only.
    return (values,) if isinstance(values, str) else tuple(values)


@frozen
class RecordOptions:
    """Options of a recording: the file, and how much of the program is in it."""

    path: Path = field(converter=Path)
    """The file. Its suffix chooses the recorder: `.mcap` is for rosbase-mcap."""
    topics: tuple[str, ...] = field(default=(), converter=_texts)
    """Full names of the topics; none stands for all."""
    last_s: float | None = field(default=None, validator=_not_negative)
    """Keep only this time in memory, in seconds. It is written to the file if an error ends the
    program, or when `save` is called."""
    split_bytes: int = field(default=0, validator=_not_negative)
    """Begin another file when one is that long; 0 for never."""
    split_s: float = field(default=0.0, validator=_not_negative)
    """Begin another file after this time, in seconds; 0 for never."""
    compression: str = ""
    """How the file is compressed, such as `lz4` or `zstd`; empty for not at all."""

    def to_text(self) -> str:
        """Return the options as a text for the environment."""
        return json.dumps({**asdict(self), "path": str(self.path)})

    @classmethod
    def from_text(cls, text: str) -> "RecordOptions":
        """Return the options in a text: the path alone, or the result of `to_text`.

        Raises:
            ConfigurationError: It is neither.
        """
        if not text.startswith("{"):
            return cls(text)
        try:
            return cls(**json.loads(text))
        except (TypeError, ValueError) as error:
            raise ConfigurationError(f"{text!r} are no options of a recording") from error


class Recording(Protocol):
    """The recording of one program. A plugin implements it; see `RecorderPlugin`."""

    @property
    def entries(self) -> "RecordingSink | None":
        """Takes the entries of the program, so that it can be replayed; None if it needs none.

        Its `begin` and its `close` are called before those of the recording.
        """
        ...

    def begin(self, backend: "Backend", logger: "RosbaseLogger") -> None:
        """Begin to record.

        Called before the components of the program are built, on the thread that builds them.

        Args:
            backend: Connection of the program.
            logger: Says what cannot be recorded. It also says so, once, if the recording ends
                early: the program goes on.
        """
        ...

    def save(self) -> Path | None:
        """Write now what is kept in memory, and return the file; None if nothing is kept.

        Call it from any thread. It may take as long as the disk does.

        Raises:
            RecordingError: The file cannot be written.
        """
        ...

    def close(self, error: BaseException | None) -> None:
        """End the recording, in bounded time. Idempotent. Raises nothing.

        Called at the end of the program, when its backend is closed.

        Args:
            error: What has ended the program; None if it has ended in order.
        """
        ...
