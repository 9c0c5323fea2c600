"""The fenced blocks of the documentation, and what the comment above each says of running it.

A comment directly above a block is one of these:

- `not run: why`: the block is shown and not run.
- `on ROS 2`: it needs rclpy, so the tests in `tests/ros2` run it.
- `device` or `device: {"ax": 0}`: a simulated device stands in for `/dev/ttyUSB0`, and sends
  samples of the preset `ros`, or that line again and again.
- `ends with status 1`: the command does, because it shows a failure.
- `logs errors`: the program logs errors, and ends well.
- `prints`: a block of text that is exactly what the Python program above it prints.
- `payload` and `gives`: a payload, and the samples that the parameters between the two make of it.

Two of them are joined with a semicolon. A block whose first line is a comment with a path, such as
`# imu.toml`, is the file of that name for the commands of the same page. One with `title=` behind
its kind is a file of the rendered template, which `tests/authors` puts there.
"""

import re
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    [
        *ROOT.glob("*.md"),
        *ROOT.glob("docs/**/*.md"),
        *ROOT.glob("packages/*/*.md"),
        ROOT / "tests/README.md",
    ]
)
DEVICE = "/dev/ttyUSB0"

# A comment that stands elsewhere, such as `generated: roles`, says nothing of a block further down.
_BLOCK = re.compile(
    r"(?:<!-- (?P<says>(?:(?!-->).)+) -->\n)?"
    r"```(?P<kind>\w*)(?: title=(?P<title>\S+))?\n(?P<text>.*?)```",
    re.S,
)
_FILE = re.compile(r"# (\S*\.\w+)\n")


class Block(NamedTuple):
    """A fenced block of a page."""

    page: Path
    kind: str
    text: str
    says: str
    prints: str | None
    title: str
    """The file of the rendered template that it is, if it is one."""

    @property
    def is_run_here(self) -> bool:
        """Whether it is run with rosbase and its transports alone."""
        return not (self.says.startswith("not run: ") or self.is_for_ros or self.title)

    @property
    def is_for_ros(self) -> bool:
        return "on ROS 2" in self.says

    @property
    def status(self) -> int:
        """The exit status of the command."""
        return 1 if "ends with status 1" in self.says else 0

    @property
    def device(self) -> str | None:
        """What a device sends while it runs, or an empty text for samples; None without one."""
        found = re.search(r"\bdevice(?:: (.+))?$", self.says)
        return (found[1] or "") if found else None

    @property
    def file(self) -> str:
        """The file that it is, if it says so."""
        found = _FILE.match(self.text)
        return found[1] if found else ""


def _blocks_of(page: Path) -> list[Block]:
    found = list(_BLOCK.finditer(page.read_text()))
    following = [*found[1:], None][: len(found)]
    return [
        Block(page, m["kind"], m["text"], m["says"] or "", _printed(after), m["title"] or "")
        for m, after in zip(found, following, strict=True)
    ]


def _printed(after: re.Match[str] | None) -> str | None:
    """What a program prints, if the block after it says that it is this."""
    return str(after["text"]) if after is not None and after["says"] == "prints" else None


BLOCKS = {
    f"{page.relative_to(ROOT)}:{number}": block
    for page in PAGES
    for number, block in enumerate(_blocks_of(page), start=1)
}


def blocks_of(page: str, kind: str) -> list[Block]:
    """The blocks of a kind on a page."""
    return [b for b in BLOCKS.values() if b.page == ROOT / page and b.kind == kind]


def write_files(page: Path, folder: Path, device: str) -> None:
    """Writes the files that a page shows into a folder, for the device that is there."""
    for block in BLOCKS.values():
        if block.page == page and block.file:
            (folder / Path(block.file).name).write_text(block.text.replace(DEVICE, device))
