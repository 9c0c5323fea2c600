"""Find the source for what the user named."""

import sys
from pathlib import Path

from rosbase import ConfigurationError
from rosbase.plugins.our_packages import how_to_install
from rosbase_view.attached.source import AttachedSource
from rosbase_view.options import RECORDING
from rosbase_view.source import Source

__all__ = ["open_source"]


def open_source(name: str | None) -> Source:
    """Return the source of running programs, or of a recording.

    Args:
        name: A program, the pid of its process, or the path of a recording; None for all programs.

    Raises:
        ControlError: No program has that name, or several have.
        ConfigurationError: The recording cannot be read.
    """
    if name is not None and name.endswith(RECORDING):
        return _open_recording(Path(name))
    source = AttachedSource(name)
    source.check()
    return source


def _open_recording(path: Path) -> Source:
    try:
        from rosbase_view.recorded.mcap_file import McapFile  # noqa: PLC0415 - another package
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "rosbase_mcap":
            raise
        text = f"recordings need the package rosbase-mcap: {how_to_install('rosbase-mcap')}"
        raise ConfigurationError(text) from None
    from rosbase_view.recorded.source import RecordedSource  # noqa: PLC0415 - as above

    def say_mending() -> None:
        # It takes a minute for some gigabytes.
        print(
            f"rosbase view: {path} was cut off; a copy is mended ...", file=sys.stderr, flush=True
        )

    return RecordedSource(McapFile(path, say_mending))
