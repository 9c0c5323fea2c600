"""Record a manager or a standalone node from its first moment to its last."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.contracts.recording import Recording, RecordOptions
from rosbase.entries.current import conduct_next, is_replay_next, set_running
from rosbase.entries.kinds import Kind
from rosbase.errors import ConfigurationError
from rosbase.logger import RosbaseLogger
from rosbase.roles.connection import is_child, open_backend, open_logger

__all__ = [
    "RECORD_VARIABLE",
    "end_recording",
    "follow_stops",
    "has_no_signals",
    "note_interruption",
    "open_program",
    "recorded",
    "run_aside",
]

RECORD_VARIABLE = "ROSBASE_RECORD"
"""Environment variable with the file to which the first program of this process is recorded."""

_is_taken = False
_LATER = "this program is not recorded: the recording is of the first of its process"


def open_program(
    record: str | Path | RecordOptions | None,
    backend: str | Backend | None,
    options: BackendOptions,
    custom_logger: Callable[[str], Any] | None,
) -> tuple[Backend, RosbaseLogger, Recording | None]:
    """Open the backend and the logger of a program, and begin the recording that it wants.

    Args:
        record: What to record, as the program has it; None leaves it to the environment.
        backend: The backend, by name or ready made.
        options: Options of a backend by name.
        custom_logger: A class of the application, which is called with the name.

    Raises:
        ConfigurationError: The options of the recording are invalid.
        NotInstalledError: There is no such backend, or no recorder for such a file.
        RecordingError: The file cannot be created.
    """
    wanted, remark = _wanted(record, backend)
    # Before the backend: the program has another clock and another executor while it is recorded.
    recording = _open(wanted, backend) if wanted is not None else None
    opened: Backend | None = None
    try:
        opened = open_backend(backend, options)
        logger = open_logger(opened, options.node_name, custom_logger)
        if recording is not None:
            recording.begin(opened, logger)
        elif remark:
            logger.info(remark)
    except BaseException as error:
        if recording is not None:
            conduct_next(None)
            end_recording(recording, opened, error)
        if opened is not None:
            opened.close()
        raise
    return opened, logger, recording


@contextmanager
def recorded(recording: Recording | None, backend: Backend) -> Iterator[None]:
    """End a recording or a replay when the block ends, with the error that has ended it."""
    try:
        yield
    except BaseException as error:
        is_success = isinstance(error, SystemExit) and not error.code
        end_recording(recording, backend, None if is_success else error)
        raise
    end_recording(recording, backend, None)


def end_recording(
    recording: Recording | None, backend: Backend | None, error: BaseException | None
) -> None:
    """End the recording or the replay of a program, if there is one. Idempotent."""
    if backend is not None and backend.conductor is not None:
        backend.conductor.end(error)
        set_running(None)
    if recording is not None:
        recording.close(error)


def note_interruption(backend: Backend, error: BaseException) -> None:
    """Note in a recording that an interrupt has ended a callback, which no replay can repeat."""
    if backend.conductor is not None and isinstance(error, KeyboardInterrupt):
        backend.conductor.spoil("a callback was interrupted by a signal")


def follow_stops(backend: Backend, stop_now: Callable[[], object]) -> None:
    """Let a replay stop the program where the recorded one was asked to stop."""
    if backend.conductor is not None:
        backend.conductor.register(Kind.STOP, lambda _: stop_now())


def run_aside(backend: Backend, upkeep: Callable[[], object]) -> None:
    """Run upkeep, of which a recording has nothing."""
    if backend.conductor is not None:
        backend.conductor.aside(upkeep)
    else:
        upkeep()


def has_no_signals(backend: Backend) -> bool:
    """Return whether the program runs in a test, whose runner has the signals."""
    is_replay = backend.conductor is not None and backend.conductor.is_replay
    return backend.is_in_virtual_time and not is_replay


def _wanted(
    record: str | Path | RecordOptions | None, backend: str | Backend | None
) -> tuple[RecordOptions | None, str]:
    """Return what to record, and what to say if that is nothing."""
    conductor = backend.conductor if isinstance(backend, Backend) else None
    if is_replay_next() or (conductor is not None and conductor.is_replay):
        # The recording is the one that is replayed.
        return None, ""
    return _given() if record is None else (_options(record), "")


def _open(options: RecordOptions, backend: str | Backend | None) -> Recording:
    # Only now: finding plugins takes longer than everything else that `import rosbase` does.
    from rosbase.entries.recorder import Recorder
    from rosbase.plugins import installed_plugins

    name = options.path.suffix.removeprefix(".")
    if not name:
        raise ConfigurationError(f"{options.path}: a recording has a suffix, such as .mcap")
    recording = installed_plugins().recorder(name).open(options)
    entries = recording.entries
    if entries is None:
        return recording
    if not isinstance(backend, Backend):
        conduct_next(partial(Recorder, sink=entries))
    elif isinstance(backend.conductor, Recorder):
        backend.conductor.record_into(entries)
    return recording


def _options(wanted: str | Path | RecordOptions) -> RecordOptions:
    if isinstance(wanted, RecordOptions):
        return wanted
    if isinstance(wanted, (str, Path)):
        return RecordOptions(wanted)
    raise TypeError(f"record is a path or RecordOptions, not {wanted!r}")


def _given() -> tuple[RecordOptions | None, str]:
    """Return what the user wants of the first program of this process."""
    global _is_taken  # noqa: PLW0603 - it concerns the process
    text = os.environ.get(RECORD_VARIABLE, "")
    if not text or is_child():
        return None, ""
    if _is_taken:
        return None, _LATER
    options = RecordOptions.from_text(text)
    _is_taken = True
    return options, ""
