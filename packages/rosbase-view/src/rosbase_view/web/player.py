"""Controls of a recording: a button that plays and pauses, and where the recording is."""

import math
from collections.abc import Callable
from typing import Any, TypeAlias

import viser
from attrs import frozen

from rosbase_view.reports import Position
from rosbase_view.source import Playback
from rosbase_view.web.elements import update

__all__ = ["PlayOrPause", "Played", "Player", "Seek", "play"]

_NS = 1e9
_STEP_S = 0.1


@frozen
class PlayOrPause:
    """The user has pressed the button."""


@frozen
class Seek:
    """The user has moved the slider."""

    seconds: float
    """Seconds after the beginning."""


Played: TypeAlias = PlayOrPause | Seek


def play(played: Played, playback: Playback, position: Position) -> None:
    """Do to a recording what the user wants."""
    if isinstance(played, Seek):
        playback.seek(position.begin_ns + int(played.seconds * _NS))
    elif position.is_playing:
        playback.pause()
    else:
        playback.play()


class Player:
    """The controls; hidden for what runs."""

    def __init__(self, gui: viser.GuiApi, on_played: Callable[[Played], object]) -> None:
        """Make the elements.

        Args:
            gui: The panel.
            on_played: Takes what users do, on a thread of viser's.
        """
        self.button = gui.add_button("play", visible=False)
        self.slider = gui.add_slider(
            "seconds", min=0.0, max=_STEP_S, step=_STEP_S, initial_value=0.0, visible=False
        )

        @self.button.on_click
        async def _(_: viser.GuiEvent[Any]) -> None:
            on_played(PlayOrPause())

        @self.slider.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # Without a client, the change is our own.
            if event.client_id is not None:
                on_played(Seek(event.target.value))

    def show(self, position: Position | None) -> None:
        """Show where a recording is; nothing for what runs."""
        update(self.button, visible=position is not None)
        update(self.slider, visible=position is not None)
        if position is None:
            return
        steps = math.ceil((position.end_ns - position.begin_ns) / (_STEP_S * _NS))
        length_s = round(max(1, steps) * _STEP_S, 1)
        passed_s = min(max(0.0, (position.now_ns - position.begin_ns) / _NS), length_s)
        update(self.button, label="pause" if position.is_playing else "play")
        # The end first: the slider moves no further.
        update(self.slider, max=length_s)
        update(self.slider, value=round(passed_s, 1))
