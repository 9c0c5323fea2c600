"""Record a manager or a standalone node from its first moment to its last."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rosbase.contracts.backend import Backend
from rosbase.contracts.recording import Recording, RecordOptions
from rosbase.errors import ConfigurationError
from rosbase.logger import RosbaseLogger
from rosbase.roles.connection import is_child

__all__ = ["RECORD_VARIABLE", "begin_recording", "recorded"]

RECORD_VARIABLE = "ROSBASE_RECORD"
"""Environment variable with the file to which the first program of this process is recorded."""

_is_taken = False


def begin_recording(
    wanted: str | Path | RecordOptions | None, backend: Backend, logger: RosbaseLogger
) -> Recording | None:
    """Begin the recording that a program or its user wants; return None if neither does.

    Args:
        wanted: As the program has it; None leaves it to the environment.
        backend: Connection of the program.
        logger: Says what cannot be recorded.

    Raises:
        ConfigurationError: The options are invalid.
        NotInstalledError: There is no recorder for such a file.
        RecordingError: The file cannot be created.
    """
    options = _given(logger) if wanted is None else _options(wanted)
    if options is None:
        return None
    # Only now: finding plugins takes longer than everything else that `import rosbase` does.
    from rosbase.plugins import installed_plugins

    name = options.path.suffix.removeprefix(".")
    if not name:
        raise ConfigurationError(f"{options.path}: a recording has a suffix, such as .mcap")
    recording = installed_plugins().recorder(name).open(options)
    try:
        recording.begin(backend, logger)
    except BaseException as error:
        recording.close(error)
        raise
    return recording


@contextmanager
def recorded(recording: Recording | None) -> Iterator[None]:
    """End a recording when the block ends, with the error that has ended it."""
    try:
        yield
    except BaseException as error:
        if recording is not None:
            is_success = isinstance(error, SystemExit) and not error.code
            recording.close(None if is_success else error)
        raise
    if recording is not None:
        recording.close(None)


def _options(wanted: str | Path | RecordOptions) -> RecordOptions:
    if isinstance(wanted, RecordOptions):
        return wanted
    if isinstance(wanted, (str, Path)):
        return RecordOptions(wanted)
    raise TypeError(f"record is a path or RecordOptions, not {wanted!r}")


def _given(logger: RosbaseLogger) -> RecordOptions | None:
    """Return what the user wants of the first program of this process."""
    global _is_taken  # noqa: PLW0603 - it concerns the process
    text = os.environ.get(RECORD_VARIABLE, "")
    if not text or is_child():
        return None
    if _is_taken:
        logger.info("this program is not recorded: the recording is of the first of its process")
        return None
    options = RecordOptions.from_text(text)
    _is_taken = True
    return options
