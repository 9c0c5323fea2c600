"""A dialogue in which the user edits a value."""

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

__all__ = ["ValueEditor"]


class ValueEditor(ModalScreen[str | None]):
    """One line to edit; the result is the new text, or None if the user gave up."""

    DEFAULT_CSS = """
    ValueEditor { align: center middle; }
    ValueEditor > Vertical { width: 60; max-width: 100%; height: auto; padding: 1 2;
                             background: $surface; }
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
            yield Input(self._text, select_on_focus=False)
            yield Static("enter: set   escape: give up", markup=False)

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """End with the new text."""
        event.stop()
        self.dismiss(event.value)

    def action_give_up(self) -> None:
        """End without a change."""
        self.dismiss(None)
