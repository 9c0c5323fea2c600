"""News for the user: a line on the terminal, and in the clients."""

import sys

from rosbase_view.foxglove.server import Server

__all__ = ["Notices"]


class Notices:
    """Says each thing once, until it has ended."""

    def __init__(self, server: Server) -> None:
        """Begin with nothing to say."""
        self._server = server
        self._said: dict[str, str] = {}

    def say(self, about: str, text: str) -> None:
        """Say something about a subject, unless it was the last thing about it."""
        if self._said.get(about) == text:
            return
        self._said[about] = text
        # stderr: what is on stdout is the address.
        print(f"rosbase view: {text}", file=sys.stderr, flush=True)
        self._server.warn(text, about)

    def end(self, about: str, text: str | None = None) -> None:
        """Say that a subject has ended, if anything was said about it."""
        if self._said.pop(about, None) is None:
            return
        if text is not None:
            print(f"rosbase view: {text}", file=sys.stderr, flush=True)
        self._server.unwarn(about)
