"""Words under which the search of the site shows a section first."""

__all__ = ["entries"]


def entries(words: str) -> str:
    """Return an entry of the index for each of the words, which a comma separates.

    A main entry, with the exclamation mark, is found before pages that only use the word.
    """
    marked = ", ".join(f"! {word.strip()}" for word in words.split(","))
    return f":::{{index}} {marked}\n:::\n"
