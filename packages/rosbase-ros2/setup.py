"""For `colcon build`, which runs it; pip does not. What it says is read from pyproject.toml."""

from pathlib import Path, PurePosixPath

from setuptools import Distribution, setup

try:
    import tomllib
except ModuleNotFoundError:
    # Python 3.10: rosbase-core needs this package there.
    import tomli as tomllib

# With --symlink-install, a link to this file runs, in a folder without pyproject.toml.
config = tomllib.loads(Path(__file__).resolve().with_name("pyproject.toml").read_text())
project = config["project"]
data = config["tool"]["hatch"]["build"]["targets"]["wheel"]["shared-data"]


class PlainDistribution(Distribution):
    """Keeps setuptools from reading pyproject.toml.

    colcon fails on what it makes of `requires-python`, and the setuptools of Ubuntu 24.04 on
    `license`.
    """

    def parse_config_files(self, filenames=None, ignore_option_errors=False):
        """Reads the other files."""
        super().parse_config_files(filenames or self.find_config_files(), ignore_option_errors)


setup(
    distclass=PlainDistribution,
    name=project["name"],
    version=project["version"],
    entry_points={
        group: [f"{name} = {value}" for name, value in entries.items()]
        for group, entries in project["entry-points"].items()
    },
    packages=["rosbase_ros2"],
    package_dir={"": "src"},
    package_data={"rosbase_ros2": ["py.typed"]},
    data_files=[(str(PurePosixPath(target).parent), [source]) for source, target in data.items()],
)
