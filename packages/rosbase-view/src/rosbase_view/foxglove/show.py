"""Serve a source to Foxglove, Lichtblick and PlotJuggler until the user ends it."""

import sys
from pathlib import Path
from typing import Protocol

from rosbase import SystemClock
from rosbase_view.foxglove.ending import Ending
from rosbase_view.foxglove.live_bridge import LiveBridge
from rosbase_view.foxglove.playback_bridge import PlaybackBridge
from rosbase_view.foxglove.sdk_log import sdk_log
from rosbase_view.options import LOOPBACK, Options
from rosbase_view.source import Source

__all__ = ["check", "run"]


class _Bridge(Protocol):
    def start(self, name: str, host: str, port: int) -> int: ...

    def close(self) -> None: ...


def check(_: Options) -> None:
    """Check nothing: whether the port is free shows when it is opened."""


def run(source: Source, options: Options) -> int:
    """Serve the source; return the exit status.

    Raises:
        ConfigurationError: The port is in use, or there is no such address.
    """
    if options.host != LOOPBACK:
        print(
            f"rosbase view: whoever reaches {options.host} can set parameters and call services:"
            " the protocol knows no password",
            file=sys.stderr,
        )
    with Ending() as ending, sdk_log():
        bridge: _Bridge
        if source.playback is None:
            # A view takes the newest messages of what it shows. Clients want each message, and
            # nothing of what they do not listen to.
            source.close()
            bridge = LiveBridge(options.name, SystemClock(), ending.fail)
            name = options.name or "all programs"
        else:
            bridge = PlaybackBridge(source, source.playback, SystemClock(), ending.fail)
            name = Path(options.name or "").name
        try:
            port = bridge.start(f"rosbase: {name}", options.host, options.port)
            address = f"ws://{options.host}:{port}"
            print(f"rosbase view: {name} at {address} (Ctrl-C to end)", flush=True)
            ending.wait()
        finally:
            bridge.close()
    return 0
