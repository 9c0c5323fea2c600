"""The whole check of rosbase: `nox` runs it, `nox -l` lists its parts.

Each session builds the wheels that it needs and installs them into an environment of its
own, as a user would. uv does that in a fifth of the time; without it, pip does.
"""

import atexit
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import nox
from nox.command import CommandFailed

nox.options.default_venv_backend = "uv|virtualenv"
nox.options.reuse_existing_virtualenvs = True
nox.needs_version = ">=2024.4.15"

PACKAGES = Path("packages")
EXAMPLES = Path("docs/examples")
# A distribution, the packages that its wheel needs beside those from the index, its tests.
DISTRIBUTIONS = {
    "rosbase-core": (["rosbase-core"], "tests/core"),
    "imu-serial": (["rosbase-core", "imu-serial"], "tests/imu_serial"),
    "imu-mqtt": (["rosbase-core", "imu-mqtt"], "tests/imu_mqtt"),
    "rosbase-mcap": (["rosbase-core", "rosbase-mcap"], "tests/rosbase_mcap"),
    # Recordings are viewed too.
    "rosbase-view": (["rosbase-core", "rosbase-mcap", "rosbase-view"], "tests/view"),
}
# Tests that often keep a processor busy. The others mostly wait: for time, brokers and processes.
BUSY = {"tests/ros2"}
# More failures than these are no stall of the machine.
FEW_FAILURES = 5
# A line for each, in the order of the sessions.
FAILURES: list[str] = []
# rosbase-ros2 brings 200 MB of ROS along, so it is not in every environment.
ALL = [*DISTRIBUTIONS, "rosbase-ros2"]
# What a distribution is to be installed with.
EXTRAS = {"imu-mqtt": "[broker]", "rosbase-view": "[foxglove,web]"}
# Pictures of the view depend on the version.
PINS = {"rosbase-view": ["rich==14.3.4", "textual==8.2.8"]}
# A client of Foxglove's protocol that is not the SDK's own.
SOCKETS = "websockets>=15"
TEST_TOOLS = ["hypothesis>=6.100", "pytest>=8", "pytest-timeout>=2.3", "pytest-xdist>=3.6"]
# Shows what a command has written to a terminal.
TERMINAL = "pyte>=0.8"
# Renders the template for a plugin; pyright with its own Node.js, from the package index too.
PROGRAM_TOOLS = ["copier>=9", "pyright[nodejs]==1.1.414"]
LINTERS = ["ruff==0.17.6"]
# The packages of which rosbase has the messages; rclpy brings the others.
ROS_MESSAGES = [
    f"ros-jazzy-{name}"
    for name in (
        *("diagnostic-msgs", "geometry-msgs", "lifecycle-msgs", "nav-msgs", "rclpy[fastrtps]"),
        *("sensor-msgs", "std-msgs", "std-srvs", "trajectory-msgs", "visualization-msgs"),
    )
]
# What our bytes, schemas and hashes are compared with.
WIRE_ORACLES = ["numpy", "ros-jazzy-test-msgs", "rosbags>=0.10", *ROS_MESSAGES]
# Other readers of recordings.
MCAP_ORACLES = ["mcap>=1.2", "mcap-ros2-support>=0.5", "rosbags>=0.10"]
# Of all Pythons, which replay those of each other.
RECORDINGS = Path(".nox/recordings").resolve()
MESSAGES = PACKAGES / "rosbase-core/src/rosbase/messages"
# The front page shows the screen of a command.
SITE_TOOLS = [
    "sphinx==9.0.4",
    "myst-parser==5.2.0",
    "furo==2025.12.19",
    "sphinx-copybutton==0.5.2",
    "mermaid-render==0.14.1",
    TERMINAL,
]


def _pythons() -> list[str]:
    """Every Python from 3.10 up that this machine has and that starts."""
    found = [f"{sys.version_info.major}.{sys.version_info.minor}"]
    for minor in range(10, 20):
        name = f"python3.{minor}"
        # A version manager may put a name on the path behind which there is nothing.
        if shutil.which(name):
            started = subprocess.run([name, "-V"], check=False, capture_output=True)
            found += [f"3.{minor}"] * (started.returncode == 0)
    supported = {version for version in found if int(version.split(".")[1]) >= 10}
    return sorted(supported, key=lambda version: int(version.split(".")[1]))


PYTHONS = _pythons()
# For sessions on one Python: the oldest that the documentation's tools support.
TOOLS_PYTHON = next((version for version in PYTHONS if version != "3.10"), PYTHONS[0])
# With all of them, `nox` alone would take too long. Others run by name, as `nox -s ros2-3.12`.
ENDS = sorted({PYTHONS[0], PYTHONS[-1]}, key=PYTHONS.index)
nox.options.sessions = [
    *(f"tests-{python}(distribution={name!r})" for name in DISTRIBUTIONS for python in ENDS),
    *(f"{name}-{python}" for name in ("ros2", "integration") for python in ENDS),
    *(f"{name}-{TOOLS_PYTHON}" for name in ("authors", "docs", "colcon", "messages")),
    *("lint", "typing", "imports", "demo", "build"),
]


def _test(session: nox.Session, folder: str, *options: str) -> None:
    """Runs the tests of a folder, up to twice as many at a time as there are processors.

    Many of them check a time limit, and a machine that stalls for a second breaks it. So a few
    that fail beside others run once more, alone. The session names them in its log.
    """
    # Not in nox's own folder for temporary files, which would become that of the tests too.
    cache = Path(session.virtualenv.location).resolve() / "pytest"
    shutil.rmtree(cache, ignore_errors=True)
    report = cache / "report.xml"
    told = ["-o", f"cache_dir={cache}", f"--junitxml={report}"]
    command = ["pytest", "-q", *told, *options, folder, *session.posargs]
    processors = max(2, os.cpu_count() or 1)
    at_once = processors * 3 // 2 if folder in BUSY else processors * 2
    try:
        session.run(*command, "-n", str(at_once))
    except CommandFailed:
        _note_failures(session, report, "beside others")
        record = cache / "v" / "cache" / "lastfailed"
        failed = json.loads(record.read_text()) if record.exists() else {}
        if not 0 < len(failed) <= FEW_FAILURES:
            raise
        session.warn(f"failed beside others, and run again alone: {', '.join(failed)}")
        try:
            session.run(*command, "--last-failed", "--last-failed-no-failures=none", "-n", "0")
        except CommandFailed:
            _note_failures(session, report, "alone too")
            raise


def _note_failures(session: nox.Session, report: Path, how: str) -> None:
    """Notes what a run of pytest reports of its failures, for the end of the log."""
    if not report.exists():
        return
    for case in ElementTree.parse(report).iter("testcase"):
        for failure in (*case.findall("failure"), *case.findall("error")):
            text = failure.get("message", "").partition("\n")[0][:300]
            name = f"{case.get('classname')}::{case.get('name')}"
            FAILURES.append(f"{session.name}: failed {how}: {name}: {text}")
    report.unlink()


@atexit.register
def _say_failures() -> None:
    """At the end of a log of thousands of lines, says which tests failed, and why."""
    for line in FAILURES:
        print(line, file=sys.stderr)


def _test_on_each(session: nox.Session, folder: str) -> None:
    """Runs the tests of a folder on one of all Pythons; those marked `once`, on the oldest only."""
    _test(session, folder, *([] if session.python == PYTHONS[0] else ["-m", "not once"]))


def _install(session: nox.Session, *names: str) -> None:
    """Builds these distributions as they are now, and installs them with what they need."""
    sources = (f"./{PACKAGES / name}{EXTRAS.get(name, '')}" for name in names)
    session.install("--force-reinstall", *sources)


@nox.session(python=PYTHONS)
@nox.parametrize("distribution", list(DISTRIBUTIONS))
def tests(session: nox.Session, distribution: str) -> None:
    """The tests of one distribution, with nothing else of ours installed."""
    names, folder = DISTRIBUTIONS[distribution]
    # Vectors and buffers of messages may be arrays of numpy, which rosbase itself never imports.
    # Our rotations are compared with those of transforms3d.
    session.install("numpy", "transforms3d>=0.4.2", *TEST_TOOLS)
    if distribution == "rosbase-mcap":
        session.install(*MCAP_ORACLES)
    if distribution == "rosbase-view":
        session.install(SOCKETS, *MCAP_ORACLES)
    _install(session, *names)
    if pins := PINS.get(distribution):
        session.install(*pins)
    _test_on_each(session, folder)


@nox.session(python=PYTHONS)
def ros2(session: nox.Session) -> None:
    """The tests on real rclpy, from the package index, and in other processes."""
    # With an action, which no package has that ours needs.
    session.install(*WIRE_ORACLES, *TEST_TOOLS)
    _install(session, *ALL)
    _test_on_each(session, "tests/ros2")


@nox.session(python=TOOLS_PYTHON)
def messages(session: nox.Session) -> None:
    """Generate the messages anew from the ROS packages; fails if they were out of date."""
    session.install(*ROS_MESSAGES, *LINTERS)
    before = _texts(MESSAGES)
    session.run("python", "tools/generate_messages.py")
    session.run("ruff", "check", "-q", "--fix", "--select", "I,RUF022", str(MESSAGES))
    session.run("ruff", "format", "-q", str(MESSAGES))
    after = _texts(MESSAGES)
    changed = sorted(name for name in before | after if before.get(name) != after.get(name))
    if changed:
        session.error(f"were out of date, and are generated anew: {', '.join(changed)}")


def _texts(folder: Path) -> dict[str, str]:
    return {str(file.relative_to(folder)): file.read_text() for file in folder.rglob("*.py")}


@nox.session(python=PYTHONS)
def integration(session: nox.Session) -> None:
    """All distributions together, as processes, on real lines."""
    session.install("pyyaml>=6", TERMINAL, *TEST_TOOLS)
    _install(session, *DISTRIBUTIONS)
    _test_on_each(session, "tests/integration")


@nox.session(python=TOOLS_PYTHON)
def authors(session: nox.Session) -> None:
    """Plugins of somebody else: the UDP example, and the template as its page fills it in."""
    session.install("copier>=9", "hatchling", "editables", "pip", *TEST_TOOLS)
    _install(session, "rosbase-core")
    session.install("--no-deps", "--force-reinstall", str(EXAMPLES / "udp"))
    session.run("pytest", "-q", str(EXAMPLES / "udp"))
    _test(session, "tests/authors")


@nox.session(python=TOOLS_PYTHON)
def docs(session: nox.Session) -> None:
    """The site, built and looked at; every code block of the READMEs and the documentation, run."""
    session.install("numpy", *TEST_TOOLS, *SITE_TOOLS)
    _install(session, *DISTRIBUTIONS)
    # What it declares is on the site; to say so, it needs no ROS.
    session.install("--no-deps", "--force-reinstall", str(PACKAGES / "rosbase-ros2"))
    made = Path(session.create_tmp()).resolve()
    options = ["-q", "-n", "-W", "--keep-going", "-E", "-d", str(made / "pages")]
    session.run("sphinx-build", *options, "docs", str(made / "site"))
    session.log(f"the site: {made / 'site' / 'index.html'}")
    # The tests look at this one, and need not build it again.
    session.env["DOCS_SITE"] = str(made / "site")
    _test(session, "tests/docs")


@nox.session(default=False)
def pictures(session: nox.Session) -> None:
    """Draw the pictures in docs/images anew; `docs` says when they are out of date."""
    session.install(TERMINAL)
    _install(session, "rosbase-core", "imu-serial")
    session.run("python", "-m", "generators.pictures", env={"PYTHONPATH": "docs"})


@nox.session
def lint(session: nox.Session) -> None:
    """Style and formatting."""
    session.install(*LINTERS)
    session.run("ruff", "check", ".")
    session.run("ruff", "format", "--check", ".")


@nox.session
def typing(session: nox.Session) -> None:
    """The types of everything, by mypy's strictest rules; for documented programs, pyright too."""
    # It checks for the oldest Python, which has no `tomllib`.
    session.install("mypy==2.4.1", "nox", "numpy", "tomli>=2", "types-pyserial")
    session.install(SOCKETS, TERMINAL, *MCAP_ORACLES, *PROGRAM_TOOLS, *TEST_TOOLS)
    _install(session, *ALL)
    session.run("mypy", *(str(PACKAGES / name / "src") for name in ALL))
    for folder in (
        "core",
        "imu_serial",
        "imu_mqtt",
        "rosbase_mcap",
        "view",
        "ros2",
        "integration",
        "docs",
        "installs",
        "benchmarks",
    ):
        session.run("mypy", f"tests/{folder}", "tests/support", "tests/conftest.py")
    session.run("mypy", "docs/conf.py", "docs/generators")
    programs = str(Path(session.create_tmp()) / "programs")
    session.run("python", "tests/check_programs.py", programs, env={"PYTHONPATH": "tests"})
    session.run("python", "tests/check_typing_failures.py")


@nox.session
def imports(session: nox.Session) -> None:
    """Who may import whom."""
    session.install("import-linter==2.16")
    # It reads the sources, and imports nothing.
    sources = os.pathsep.join(str(PACKAGES / name / "src") for name in ALL)
    session.run("lint-imports", env={"PYTHONPATH": sources})


@nox.session
def demo(session: nox.Session) -> None:
    """The command that a newcomer runs first."""
    _install(session, *DISTRIBUTIONS)
    session.run("rosbase", "plugins")
    session.run("rosbase", "demo", "--duration", "5")


@nox.session
def build(session: nox.Session) -> None:
    """Source distributions and wheels that hold what they should; every install command."""
    session.install("build", "twine", "hatchling", "attrs", "pip", "uv", *TEST_TOOLS)
    dist = Path(session.create_tmp()) / "dist"
    shutil.rmtree(dist, ignore_errors=True)
    for name in ALL:
        # The wheel is built from the source distribution, so both are proved.
        session.run("python", "-m", "build", "-q", "-n", "-o", str(dist), str(PACKAGES / name))
    built = sorted(str(path) for path in dist.iterdir())
    session.run("twine", "check", "--strict", *built)
    session.run("python", "tests/check_wheels.py", *built)
    # For what all tests share.
    _install(session, "rosbase-core")
    _test(session, "tests/installs")


@nox.session(python=TOOLS_PYTHON)
def colcon(session: nox.Session) -> None:
    """The package for ROS as colcon builds it, with the setuptools of Ubuntu 24.04."""
    session.install("colcon-core", "colcon-ros", "setuptools==68.1.2")
    made = Path(session.create_tmp()).resolve() / "made"
    shutil.rmtree(made, ignore_errors=True)
    for kind, options in {"copied": [], "linked": ["--symlink-install"]}.items():
        bases = [f"--{base}-base={made / kind / base}" for base in ("build", "install")]
        log, source = f"--log-base={made / kind / 'log'}", f"--base-paths={PACKAGES}"
        session.run("colcon", log, "build", source, *bases, *options)
    # The other one leaves the modules where they are.
    session.run("python", "tests/check_wheels.py", str(made / "copied" / "install"))


@nox.session(default=False)
def million(session: nox.Session) -> None:
    """A million mappings and payloads, read as the documentation says: some ten minutes."""
    session.install(*TEST_TOOLS)
    _install(session, "rosbase-core")
    cases = {"ROSBASE_MAPPING_CASES": "1000000"}
    test = "tests/core/test_mapping_oracle.py"
    session.run("pytest", "-q", "-s", "--timeout", "0", test, *session.posargs, env=cases)


@nox.session(default=False)
def wire(session: nox.Session) -> None:
    """A million random messages of all classes, beside rclpy: some ten minutes."""
    session.install(*WIRE_ORACLES, *TEST_TOOLS)
    _install(session, *ALL)
    # There are about two hundred classes.
    cases = {"ROSBASE_WIRE_CASES": "6000"}
    test = "tests/ros2/test_wire_oracle.py"
    session.run("pytest", "-q", "-n", "2", test, *session.posargs, env=cases)


@nox.session(python=PYTHONS, default=False)
def programs(session: nox.Session) -> None:
    """Random programs, recorded on each Python for the session `replays`."""
    session.install(*TEST_TOOLS)
    _install(session, "rosbase-core")
    folder = RECORDINGS / str(session.python)
    shutil.rmtree(folder, ignore_errors=True)
    count = session.posargs or ["200"]
    env = {"PYTHONPATH": "tests"}
    session.run("python", "tests/replays.py", "record", str(RECORDINGS), *count, env=env)


@nox.session(python=PYTHONS, default=False)
def replays(session: nox.Session) -> None:
    """The recordings of all Pythons, replayed on each; `nox -s programs replays` makes both."""
    _install(session, "rosbase-core")
    session.install(*TEST_TOOLS)
    env = {"PYTHONPATH": "tests"}
    session.run("python", "tests/replays.py", "replay", str(RECORDINGS), env=env)


@nox.session(default=False)
def hour(session: nox.Session) -> None:
    """An hour of a robot at 200 Hz, recorded in real time and replayed twenty times: two hours."""
    session.install(*TEST_TOOLS)
    _install(session, *DISTRIBUTIONS)
    runs = {"ROSBASE_REPLAY_SECONDS": "3600", "ROSBASE_REPLAY_COUNT": "20"}
    test = "tests/integration/test_replays.py"
    session.run("pytest", "-q", "-s", test, *session.posargs, env=runs)


@nox.session(default=False)
def signals(session: nox.Session) -> None:
    """Two hundred programs, with two or three signals each at random moments: some ten minutes."""
    session.install(*TEST_TOOLS)
    _install(session, "rosbase-core")
    options = ["-q", "-n", "4", "tests/core/test_signals.py", "-k", "random_moments"]
    session.run("pytest", *options, *session.posargs, env={"ROSBASE_SIGNAL_RUNS": "200"})


@nox.session(default=False)
def launcher(session: nox.Session) -> None:
    """Fifty programs up and down twenty times, with SIGKILL at random moments: some ten minutes."""
    session.install(*TEST_TOOLS)
    _install(session, "rosbase-core")
    runs = {"ROSBASE_LAUNCHER_RUNS": "20", "ROSBASE_LAUNCHER_PROGRAMS": "50"}
    test = "tests/core/test_launcher_campaign.py"
    session.run("pytest", "-q", test, *session.posargs, env=runs)


@nox.session(default=False)
def recordings(session: nox.Session) -> None:
    """A hundred recordings cut off by SIGKILL, mended, and read by all readers: some minutes."""
    session.install(*MCAP_ORACLES, *ROS_MESSAGES, *TEST_TOOLS)
    _install(session, "rosbase-core", "rosbase-mcap", "rosbase-ros2")
    test = "tests/rosbase_mcap/test_kills.py"
    runs = {"ROSBASE_RECORDING_KILLS": "100"}
    session.run("pytest", "-q", "-n", "2", test, *session.posargs, env=runs)


@nox.session(default=False)
def bench(session: nox.Session) -> None:
    """How fast it is, beside the same thing by hand: all, or those named, as `-- ros2_reader`."""
    # The loop beside which `precise_loop` puts ours.
    session.install("horus-robotics==0.4.1", *WIRE_ORACLES)
    _install(session, *ALL)
    for benchmark in sorted(Path("tests/benchmarks").glob("*.py")):
        if not session.posargs or benchmark.stem in session.posargs:
            session.run("python", str(benchmark), env={"PYTHONPATH": "tests"})
