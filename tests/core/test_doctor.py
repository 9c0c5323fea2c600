"""`rosbase doctor`: how checks are run, what becomes of bad ones, and what the core checks."""

import json
import platform
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from rosbase.cli.core_checks import check_clock, check_plugins, check_python
from rosbase.cli.examination import examine
from rosbase.clock import SystemClock
from rosbase.contracts.checks import CheckContext, Finding, Outcome
from rosbase.parameters import ParameterValue
from rosbase.plugins import PluginRegistry
from rosbase.plugins.our_packages import how_to_install
from rosbase.plugins.switches import PluginSwitches
from rosbase.testing import ManualClock
from support.command import run_apart
from support.plugins import TRANSPORT_PLUGIN, candidates_in, install_plugin

CONTEXT = CheckContext(SystemClock(), {})
GOOD = "yield Finding(Outcome.OK, 'all is well')"


def install_check(folder: Path, name: str, body: str, distribution: str = "acme") -> None:
    lines = "\n    ".join(body.splitlines())
    code = f"""
import sys, threading
from rosbase.contracts.checks import Finding, Outcome
from rosbase.plugins import CheckPlugin, hookimpl

gate, both = threading.Event(), threading.Barrier(2)

def run(context):
    {lines}

@hookimpl
def rosbase_checks():
    yield CheckPlugin("{name}", "a test", run)
"""
    install_plugin(folder, distribution, name, code)


def examined(site: Path, limit_s: float = 20.0) -> list[tuple[str, Finding]]:
    return list(examine(PluginRegistry(candidates_in(site)), CONTEXT, limit_s))


@pytest.fixture
def hanging(site: Path) -> Iterator[Path]:
    """Where a check hangs as long as the test runs."""
    install_check(site, "hangs", f"{GOOD}\ngate.wait()")
    yield site
    sys.modules["acme_hangs"].gate.set()


def test_a_check_that_hangs_is_a_finding_and_what_it_found_before_is_kept(hanging: Path) -> None:
    install_check(hanging, "works", GOOD, "zeta")
    (kept, hangs, works) = examined(hanging, limit_s=0.2)
    assert kept == ("hangs", Finding(Outcome.OK, "all is well"))
    assert hangs[1].outcome is Outcome.FAIL
    assert hangs[1].text == "the check has not ended within 0.2 s"
    assert "ROSBASE_BLOCK_PLUGINS=acme:hangs" in hangs[1].advice
    assert works == ("works", Finding(Outcome.OK, "all is well"))


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("raise OSError('no\\nluck')", "the check failed: OSError: no luck"),
        ("sys.exit(3)", "the check failed: SystemExit: 3"),
        ("yield 'fine'", "the check failed: PluginError: it must yield Finding, not str"),
        ("return 5", "the check failed: TypeError: 'int' object is not iterable"),
        ("yield Finding(Outcome.FAIL, 'bad')", "'bad' does not say what to do"),
    ],
)
def test_a_check_that_is_broken_is_a_finding_and_no_traceback(
    tmp_path: Path, body: str, said: str
) -> None:
    install_check(tmp_path, "broken", body)
    done = run_apart("doctor", path=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    (at,) = [n for n, line in enumerate(done.stdout.splitlines()) if "broken: the check" in line]
    line, advice = done.stdout.splitlines()[at : at + 2]
    assert line.startswith("fail  broken: ")
    assert said in line
    assert advice.startswith(
        "      report it to the authors of acme 1.2; ROSBASE_BLOCK_PLUGINS=acme:broken"
    )


def test_checks_run_side_by_side(site: Path) -> None:
    install_check(site, "one", f"both.wait(20)\n{GOOD}")
    install_check(site, "two", f"__import__('acme_one').both.wait(20)\n{GOOD}", "zeta")
    assert [finding.outcome for _, finding in examined(site)] == [Outcome.OK, Outcome.OK]


def test_the_cores_own_checks_are_shown_first(site: Path) -> None:
    install_check(site, "own", GOOD, "rosbase-core")
    install_check(site, "other", GOOD)
    assert [name for name, _ in examined(site)] == ["own", "other"]


def test_each_finding_is_a_line_and_what_to_do_stands_indented_below(tmp_path: Path) -> None:
    install_check(
        tmp_path,
        "acme",
        "for outcome in Outcome:\n"
        "    yield Finding(outcome, f'a\\n\\x1b {outcome.value}', 'mend\\nit \u00e4')",
    )
    done = run_apart("doctor", path=tmp_path, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (1, "")
    assert [line for line in done.stdout.splitlines() if "  acme: " in line] == [
        "ok    acme: a \\x1b ok",
        "warn  acme: a \\x1b warn",
        "fail  acme: a \\x1b fail",
        "skip  acme: a \\x1b skip",
    ]
    assert done.stdout.count("\n      mend it \\xe4\n") == 4


def test_warnings_and_skipped_checks_are_no_reason_to_fail(tmp_path: Path) -> None:
    install_check(
        tmp_path, "w", "yield Finding(Outcome.WARN, 'x', 'y')\nyield Finding(Outcome.SKIP, 'x')"
    )
    done = run_apart("doctor", path=tmp_path)
    assert (done.returncode, "fail " in done.stdout) == (0, False)


@pytest.mark.parametrize("is_well", [True, False])
def test_json_says_the_same_for_machines(tmp_path: Path, is_well: bool) -> None:
    body = GOOD if is_well else "yield Finding(Outcome.FAIL, 'it is broken', 'mend it')"
    install_check(tmp_path, "w", f"print('I am looking')\n{body}")
    done = run_apart("doctor", "--json", path=tmp_path)
    assert done.stderr == "I am looking\n"
    said = json.loads(done.stdout)
    assert (done.returncode, said["ok"]) == (int(not is_well), is_well)
    assert said["findings"][-1] == (
        {"check": "w", "outcome": "ok", "text": "all is well", "advice": ""}
        if is_well
        else {"check": "w", "outcome": "fail", "text": "it is broken", "advice": "mend it"}
    )


def test_a_check_is_given_the_parameters_and_which_of_them_the_user_gave(tmp_path: Path) -> None:
    install_check(
        tmp_path,
        "w",
        'yield Finding(Outcome.OK, f\'{context.values["frame_id"]} {sorted(context.given)}'
        ' {context.values["comm_t"]}\')',
    )
    file = tmp_path / "imu.toml"
    file.write_text("stale_timeout = 2\n")
    done = run_apart("doctor", "-p", "frame_id:=left", "--params-file", str(file), path=tmp_path)
    assert "ok    w: left ['frame_id', 'stale_timeout'] serial\n" in done.stdout


def test_a_device_is_asked_for_by_its_transport_or_its_own_name() -> None:
    values: dict[str, ParameterValue] = {"comm_t": "radio", "channel": 5}
    for given, expected in ((set(), False), ({"comm_t"}, True), ({"channel"}, True)):
        context = CheckContext(SystemClock(), values, frozenset(given))
        assert context.asks_for("radio", "channel") is expected
    chosen = CheckContext(SystemClock(), values, frozenset({"comm_t"}))
    assert not chosen.asks_for("serial", "device_path")


def test_the_interpreter_is_named_and_what_nobody_has_tried_is_a_warning(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (usual,) = check_python()
    assert (usual.outcome, platform.python_version() in usual.text) == (Outcome.OK, True)
    monkeypatch.setattr(platform, "python_implementation", lambda: "Jython")
    monkeypatch.setattr(platform, "system", lambda: "Plan9")
    _, *warnings = check_python()
    assert [w.text for w in warnings] == [
        "rosbase is not tested on Jython",
        "rosbase is not tested on Plan9",
    ]
    assert all(warning.outcome is Outcome.WARN for warning in warnings)


@pytest.mark.parametrize(
    ("date_s", "outcome", "said"),
    [
        (1_795_000_000, Outcome.OK, "the date of this machine is 2026-11-18 11:06:40 UTC"),
        (300, Outcome.WARN, "1970-01-01 00:05:00 UTC: its clock was never set"),
        (2_208_988_800, Outcome.WARN, "2040-01-01 00:00:00 UTC, and ROS stamps go from 1970 to"),
        (-1, Outcome.WARN, "1969-12-31 23:59:59 UTC, and ROS stamps go from 1970 to"),
    ],
)
def test_the_date_is_told_and_one_that_makes_wrong_stamps_is_a_warning(
    date_s: int, outcome: Outcome, said: str
) -> None:
    (finding,) = check_clock(ManualClock(date_s * 1_000_000_000))
    assert finding.outcome is outcome
    assert said in finding.text
    assert ("timedatectl" in finding.advice) is (outcome is Outcome.WARN)


def test_every_plugin_is_a_finding_with_what_to_do(
    site: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    install_plugin(site, "acme", "broken", "import no_such_library")
    install_plugin(site, "beta", "blocked", "raise SystemExit")
    install_plugin(site, "imu-serial", "serial", TRANSPORT_PLUGIN.format(name="serial"))
    install_plugin(site, "void", "void", "")
    registry = PluginRegistry(candidates_in(site), PluginSwitches(("beta",)))
    monkeypatch.setenv("ROSBASE_BACKEND", "carrier")
    broken, blocked, good, empty, *others = check_plugins(registry)
    assert broken.outcome is Outcome.FAIL
    assert broken.text.startswith("acme:broken 1.2, failed: ModuleNotFoundError")
    assert "pip install --force-reinstall acme" in broken.advice
    assert blocked.outcome is Outcome.SKIP
    assert "ROSBASE_BLOCK_PLUGINS" in blocked.advice
    assert (good.outcome, good.text) == (
        Outcome.OK,
        "imu-serial:serial 1.2, active: transport: serial",
    )
    assert (empty.outcome, empty.text) == (Outcome.WARN, "void:void 1.2, active: nothing")
    assert "@hookimpl" in empty.advice
    *missing, backend = others
    assert {(f.outcome, f.text, f.advice) for f in missing} >= {
        (Outcome.SKIP, "transport 'mqtt' is not installed", how_to_install("imu-mqtt")),
        (Outcome.SKIP, "backend 'ros2' is not installed", how_to_install("rosbase-ros2")),
    }
    assert backend.outcome is Outcome.FAIL
    assert "ROSBASE_BACKEND: no backend 'carrier'" in backend.text


def test_with_the_core_alone_nothing_fails(tmp_path: Path) -> None:
    done = run_apart("doctor", path=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("ok    python: ")
    skipped = "skip  plugins: transport 'serial' is not installed\n"
    assert f"{skipped}      {how_to_install('imu-serial')}\n" in done.stdout


def test_nothing_of_a_check_is_left_when_it_has_ended(site: Path) -> None:
    install_check(site, "works", GOOD)
    before = threading.active_count()
    assert examined(site)
    assert threading.active_count() == before
