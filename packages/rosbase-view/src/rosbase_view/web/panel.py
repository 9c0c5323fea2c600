"""The panel beside the board, on viser: what is chosen, health, buttons and plots."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import viser
from viser import uplot

from rosbase_view.web.elements import update
from rosbase_view.web.model import (
    TRANSITIONS,
    ChooseNode,
    ChooseTopic,
    Picture,
    Press,
    RunTransition,
)
from rosbase_view.web.player import Played, Player
from rosbase_view.web.quantities import QUANTITIES, Quantity
from rosbase_view.web.status_html import status_html
from rosbase_view.web.trace import SPAN_S, Trace

__all__ = ["Panel"]

OnPress = Callable[[Press | Played], object]

_NONE = "none"
# Red, green and blue for x, y and z, as in all tools of ROS.
_COLOURS = ("#e03131", "#2f9e44", "#1971c2")
_PLOT_HEIGHT = 160


class Panel:
    """Shows one picture after the other; sends only what has changed.

    All browsers show the same: a choice in one of them is a choice in all.
    """

    def __init__(self, server: viser.ViserServer, on_press: OnPress, *, can_change: bool) -> None:
        """Make the elements.

        Args:
            server: The server.
            on_press: Takes what users press, on a thread of viser's.
            can_change: Whether the nodes can be changed; False for a recording.
        """
        gui = server.gui
        self._topic = _Dropdown(gui, "IMU", lambda label: on_press(ChooseTopic(label)))
        self._player = Player(gui, on_press)
        self._status = gui.add_html("")
        self._node = _Dropdown(gui, "node", lambda label: on_press(ChooseNode(label)))
        self._lifecycle = gui.add_text("lifecycle", "", disabled=True)
        self._can_change = can_change
        self._buttons = {name: _button(gui, RunTransition(name), on_press) for name in TRANSITIONS}
        self._plots = [_Plot(gui, quantity) for quantity in QUANTITIES]

    def show(self, picture: Picture, *, with_plots: bool) -> None:
        """Show a picture.

        Args:
            picture: What to show.
            with_plots: Whether to draw the plots too, which are the most to send.
        """
        self._topic.show(picture.topics, picture.topic)
        self._player.show(picture.position)
        self._node.show(picture.nodes, picture.node)
        update(self._status, content=status_html(picture))
        update(self._lifecycle, value=picture.lifecycle, visible=bool(picture.lifecycle))
        for name, button in self._buttons.items():
            update(button, visible=self._can_change and name in picture.offered)
        if with_plots:
            for plot in self._plots:
                plot.show(picture.traces.get(plot.quantity))


class _Dropdown:
    """A drop-down that is hidden while there is nothing to choose from."""

    def __init__(self, gui: viser.GuiApi, label: str, on_choice: Callable[[str], object]) -> None:
        self._handle = gui.add_dropdown(label, (_NONE,), visible=False)

        @self._handle.on_update
        async def _(event: viser.GuiEvent[Any]) -> None:
            # Without a client, the change is our own.
            if event.client_id is not None:
                on_choice(event.target.value)

    def show(self, options: Sequence[str], chosen: str) -> None:
        shown = tuple(options) or (_NONE,)
        update(self._handle, options=shown, value=chosen or _NONE, visible=bool(options))


class _Plot:
    """The curves of a quantity, with the seconds before its newest sample below them."""

    def __init__(self, gui: viser.GuiApi, quantity: Quantity) -> None:
        self.quantity = quantity
        self._shown: tuple[Trace, int] | None = None
        lines: list[uplot.Series] = [
            uplot.Series(label=name, stroke=colour, width=1.5)
            for name, colour in zip(quantity.names, _COLOURS, strict=True)
        ]
        empty = np.zeros(0)
        self._handle = gui.add_uplot(
            tuple(empty for _ in range(len(lines) + 1)),
            (uplot.Series(label="s"), *lines),
            title=f"{quantity.title}, {quantity.unit}",
            scales={
                "x": uplot.Scale(time=False, auto=False, range=(-SPAN_S, 0.0)),
                "y": uplot.Scale(range={"min": _end(-quantity.least), "max": _end(quantity.least)}),
            },
            legend=uplot.Legend(show=True),
            height=_PLOT_HEIGHT,
            visible=False,
        )

    def show(self, trace: Trace | None) -> None:
        update(self._handle, visible=trace is not None)
        if trace is None or self._shown == (trace, trace.revision):
            return
        self._shown = (trace, trace.revision)
        self._handle.data = tuple(np.array(column) for column in trace.columns())


def _end(least: float) -> dict[str, float]:
    """Return the end of a scale that is there at least; data beyond it move it."""
    return {"soft": least, "mode": 1, "pad": 0.1}


def _button(gui: viser.GuiApi, press: RunTransition, on_press: OnPress) -> viser.GuiButtonHandle:
    # There is no way back from it.
    is_final = press.transition == "shutdown"
    handle = gui.add_button(press.transition, visible=False, color="red" if is_final else None)

    @handle.on_click
    async def _(_: viser.GuiEvent[Any]) -> None:
        on_press(press)

    return handle
