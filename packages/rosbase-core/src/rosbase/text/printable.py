r"""Make text from outside safe for a line of a log, a terminal, or a message.

A topic, a file name or an error text must not be able to start a new line, clear a screen, or
reverse the reading direction. So each character that Python does not call printable is shown as an
escape, as in `lab/\x1b[2J`, and text is cut to a length. Code passes outside text through
`printable` when it enters a message. The logger, and all code that writes to a terminal, do so
once more.
"""

__all__ = ["MOST_LINE", "MOST_QUOTED", "indented", "log_line", "one_line", "printable"]

MOST_QUOTED = 200
"""Maximum length of a text that is quoted within a message."""
MOST_PROSE = 1_000
"""Maximum length of a text that stands alone, such as an error."""
MOST_LINE = 10_000
"""Maximum length of a line of a log."""

_CUT = "..."
_MOST_LINES = 200
_INDENT = "  "
_TAB = 8


def printable(text: str, most: int = MOST_QUOTED) -> str:
    r"""Return the text as one line of at most `most` printable characters.

    A text that is already such a line is returned unchanged. Otherwise line ends, control
    characters, marks of the reading direction and other invisible characters become escapes
    such as `\n`, `\x1b` and `\u202e`. A text that is too long ends in `...`.
    """
    if len(text) <= most and text.isprintable():
        return text
    pieces: list[str] = []
    length = 0
    # Each character becomes one at least, so none behind these counts.
    for character in text[: most + 1]:
        pieces.append(character if character.isprintable() else _escape(character))
        length += len(pieces[-1])
    if length <= most:
        return "".join(pieces)
    while pieces and length > most - len(_CUT):
        length -= len(pieces.pop())
    return ("".join(pieces) + _CUT)[:most]


def one_line(text: str, most: int = MOST_PROSE) -> str:
    """Return the text with one blank for each run of white space, and then as from `printable`.

    Use it for prose of several lines, such as the error of a library.
    """
    return printable(" ".join(text.split()), most)


def log_line(message: object) -> str:
    """Return the message of a record as one line: the last guard before a log."""
    return printable(str(message).expandtabs(_TAB), MOST_LINE)


def indented(text: str) -> str:
    """Return text of many lines, such as a traceback, for below the message of a record.

    Each line is indented, so that none looks like the beginning of a record.
    """
    lines = text.splitlines()
    if len(lines) > _MOST_LINES:
        half = _MOST_LINES // 2
        lines = [*lines[:half], f"... {len(lines) - 2 * half} more lines", *lines[-half:]]
    return "\n".join(_INDENT + log_line(line) for line in lines)


def _escape(character: str) -> str:
    return character.encode("unicode_escape").decode()
