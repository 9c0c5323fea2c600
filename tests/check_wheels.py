"""Checks that built distributions hold what they should, and nothing else of the tree."""

import sys
import tarfile
import zipfile


def main(paths: list[str]) -> int:
    """Prints what is wrong; gives the exit status."""
    faults = [fault for path in paths for fault in faults_of(path)]
    print("\n".join(faults) or f"{len(paths)} distributions hold what they should")
    return 1 if faults else 0


def faults_of(path: str) -> list[str]:
    """What is missing in one file, or should not be in it."""
    if path.endswith(".whl"):
        with zipfile.ZipFile(path) as wheel:
            names = wheel.namelist()
        wanted = ["/py.typed", "/entry_points.txt", "/licenses/LICENSE", "/plugin.py"]
    else:
        with tarfile.open(path) as source:
            names = source.getnames()
        wanted = ["/py.typed", "/pyproject.toml", "/LICENSE", "/README.md", "/CHANGELOG.md"]
    missing = [f"{path} lacks {end}" for end in wanted if not any(n.endswith(end) for n in names)]
    strays = [f"{path} holds {name}" for name in names if "tests/" in name or ".pyc" in name]
    return missing + strays


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
