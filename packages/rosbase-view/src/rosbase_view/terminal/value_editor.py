"""A dialogue in which the user edits a value."""

from collections.abc import Awaitable
from typing import ClassVar

from textual import events
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

__all__ = ["ValueEditor"]


class _OrderedInput(Input):
    """A line that takes its keys in their order.

    textual inserts characters at once, and runs the actions of other keys afterwards. Keys that
    come together, such as over a slow network, would so change places: a set value would be wrong.
    """

    async def _on_key(self, event: events.Key) -> None:
        action = {
            "backspace": self.action_delete_left,
            "delete": self.action_delete_right,
            "left": self.action_cursor_left,
            "right": self.action_cursor_right,
            "home": self.action_home,
            "end": self.action_end,
            "enter": self.action_submit,
        }.get(event.key)
        if action is None:
            await super()._on_key(event)
            return
        event.stop()
        event.prevent_default()
        if isinstance(done := action(), Awaitable):
            await done


class ValueEditor(ModalScreen[str | None]):
    """One line to edit; the result is the new text, or None if the user gave up."""

    DEFAULT_CSS = """
    ValueEditor { align: center middle; }
    ValueEditor > Vertical { width: 60; max-width: 100%; height: auto; padding: 0 1;
                             border: ascii $foreground; background: $surface; }
    /* The borders of textual have characters that not all terminals can show. */
    ValueEditor Input, ValueEditor Input:focus { border: none; height: 1; padding: 0;
                                                 margin: 1 0; background: $panel; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "give_up", "Give up")]

    def __init__(self, title: str, text: str) -> None:
        """Edit a text under a title."""
        super().__init__()
        self._heading = title
        self._text = text

    def compose(self) -> ComposeResult:
        """Return the title, the line and the keys."""
        with Vertical():
            # Names come from other programs, and are no markup.
            yield Static(self._heading, markup=False)
            yield _OrderedInput(self._text, select_on_focus=False)
            yield Static("enter: set   escape: give up", markup=False)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """End with the new text."""
        event.stop()
        self.dismiss(event.value)

    def action_give_up(self) -> None:
        """End without a change."""
        self.dismiss(None)
