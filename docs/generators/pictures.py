"""Writes the pictures that the README shows: `nox -s pictures`."""

from pathlib import Path

from generators import demo, roles

__all__ = ["FOLDER", "PICTURES"]

FOLDER = Path(__file__).parents[1] / "images"
PICTURES = {"demo.svg": demo.picture, "roles.svg": roles.picture}


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for name, draw in PICTURES.items():
        (FOLDER / name).write_text(draw())
