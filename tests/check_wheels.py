"""Checks that built distributions hold what they should, and nothing else of the tree.

A folder into which colcon has installed rosbase-ros2 is checked too.
"""

import sys
import tarfile
import zipfile
from pathlib import Path

PLUGIN = ["/py.typed", "/entry_points.txt", "/plugin.py"]
WHEEL = [*PLUGIN, "/licenses/LICENSE"]
SOURCE = ["/py.typed", "/pyproject.toml", "/LICENSE", "/README.md", "/CHANGELOG.md"]
# What the ROS tools look for under the prefix.
ROS = [
    "/lib/rosbase_ros2/lifecycle_manager",
    "/share/ament_index/resource_index/packages/rosbase_ros2",
    "/share/rosbase_ros2/package.xml",
]
ROS_SOURCE = ["/package.xml", "/resource/rosbase_ros2", "/scripts/lifecycle_manager", "/setup.py"]


def main(paths: list[str]) -> int:
    """Prints what is wrong; gives the exit status."""
    faults = [fault for path in paths for fault in faults_of(path)]
    print("\n".join(faults) or f"{len(paths)} distributions hold what they should")
    return 1 if faults else 0


def faults_of(path: str) -> list[str]:
    """What is missing in one of them, or should not be in it."""
    modes, wanted = contents(path)
    missing = [f"{path} lacks {end}" for end in wanted if not any(n.endswith(end) for n in modes)]
    strays = [f"{path} holds {name}" for name in modes if "tests/" in name or ".pyc" in name]
    not_run = [
        f"{path} holds {name}, which cannot be executed"
        for name, mode in modes.items()
        if name.endswith("/lifecycle_manager") and mode & 0o111 != 0o111
    ]
    return missing + strays + not_run


def contents(path: str) -> tuple[dict[str, int], list[str]]:
    """The names in it, with their modes, and how names must end."""
    is_ros = "rosbase_ros2" in Path(path).name
    if Path(path).is_dir():
        # setuptools compiles what it installs.
        files = [f for f in Path(path).rglob("*") if f.is_file() and f.suffix != ".pyc"]
        return {str(file): file.stat().st_mode for file in files}, PLUGIN + ROS
    if path.endswith(".whl"):
        with zipfile.ZipFile(path) as wheel:
            modes = {item.filename: item.external_attr >> 16 for item in wheel.infolist()}
        return modes, WHEEL + (ROS if is_ros else [])
    with tarfile.open(path) as source:
        modes = {item.name: item.mode for item in source.getmembers()}
    return modes, SOURCE + (ROS_SOURCE if is_ros else [])


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
