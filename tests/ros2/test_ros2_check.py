"""What `rosbase doctor` says of ROS, on real rclpy; one that misbehaves is played in the child."""

import json
from pathlib import Path

import pytest

from rosbase.contracts.checks import Finding, Outcome
from rosbase.testing import ManualClock
from rosbase_ros2 import check
from rosbase_ros2.check import check_ros
from support.command import run_rosbase


def findings() -> list[Finding]:
    return list(check_ros())


def test_where_ros_works_its_middleware_and_domain_are_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    node, middleware, domain = findings()
    assert {f.outcome for f in (node, middleware, domain)} == {Outcome.OK}
    assert middleware.text == (
        "the middleware is rmw_fastrtps_cpp; RMW_IMPLEMENTATION is not set; there: rmw_fastrtps_cpp"
    )
    assert domain.text == (
        "the domain is 7, as ROS_DOMAIN_ID says; ROS_AUTOMATIC_DISCOVERY_RANGE is LOCALHOST"
    )


def test_a_middleware_that_is_not_there_fails_and_does_not_end_the_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_zenoh_cpp")
    done = run_rosbase("doctor", "--json")
    assert (done.returncode, done.stderr) == (1, "")
    (failed,) = [f for f in json.loads(done.stdout)["findings"] if f["outcome"] == "fail"]
    assert (failed["check"], failed["text"]) == (
        "ros2",
        "RMW_IMPLEMENTATION is rmw_zenoh_cpp, which this rclpy does not have",
    )
    assert failed["advice"] == "unset it, install it, or use one of rmw_fastrtps_cpp"


def test_middleware_is_found_under_every_prefix_of_ros(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    index = tmp_path / "share/ament_index/resource_index/rmw_typesupport"
    index.mkdir(parents=True)
    (index / "rmw_cyclonedds_cpp").touch()
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path}:/nowhere")
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    _, middleware, _ = findings()
    assert middleware.text.endswith(
        "RMW_IMPLEMENTATION is rmw_fastrtps_cpp; there: rmw_cyclonedds_cpp, rmw_fastrtps_cpp"
    )


@pytest.mark.parametrize(
    ("domain", "outcome"),
    [
        ("233", Outcome.FAIL),
        ("x", Outcome.FAIL),
        ("-2", Outcome.FAIL),
        ("1.5", Outcome.FAIL),
        ("102", Outcome.WARN),
        ("214", Outcome.WARN),
        ("215", Outcome.OK),
        ("101", Outcome.OK),
        # As C has it, and so ROS: 8.
        ("010", Outcome.WARN),
        ("", Outcome.OK),
    ],
)
def test_a_domain_that_is_none_fails_and_one_that_may_collide_is_a_warning(
    monkeypatch: pytest.MonkeyPatch, domain: str, outcome: Outcome
) -> None:
    monkeypatch.setattr(check, "_ask_child", lambda environment: check._Answer())
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert findings()[-1].outcome is outcome


def test_a_domain_that_c_reads_otherwise_is_told_as_ros_reads_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(check, "_ask_child", lambda environment: check._Answer())
    monkeypatch.setenv("ROS_DOMAIN_ID", "010")
    domain = findings()[-1]
    assert domain.text == "ROS_DOMAIN_ID is '010', which ROS reads as 8, as in C"


def test_a_date_at_which_nothing_starts_comes_with_what_to_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    answer = check._Answer(failure="ROS 2 does not start: the date of this machine is 2040")
    monkeypatch.setattr(check, "_ask_child", lambda environment: answer)
    monkeypatch.setattr(check, "SystemClock", lambda: ManualClock(2_208_988_800_000_000_000))
    failed, _ = findings()
    assert failed.outcome is Outcome.FAIL
    assert "timedatectl" in failed.advice


def test_in_a_domain_that_is_none_the_rest_is_looked_at_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "500")
    assert [f.outcome for f in findings()] == [Outcome.OK, Outcome.OK, Outcome.FAIL]


def test_a_node_that_ros_does_not_start_fails_with_its_words(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("ROS_LOG_DIR", "/proc/nowhere")
    failed, _ = findings()
    assert failed.outcome is Outcome.FAIL
    assert "no node can be started: ROS 2 does not start: " in failed.text
    assert "/proc/nowhere" in failed.text


@pytest.mark.parametrize(
    ("rclpy", "said"),
    [
        ("raise ImportError('librmw_x.so: no such file')", "rclpy finds no middleware: pip inst"),
        ("import os; os.write(2, b'bad luck\\n'); os._exit(3)", "the process ends: bad luck"),
        ("import os; os.abort()", "the process ends: without a word"),
        ("import threading; threading.Event().wait()", "ROS has not started within 1 s"),
    ],
)
def test_an_rclpy_that_is_broken_ends_the_process_or_hangs_is_a_finding(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, rclpy: str, said: str
) -> None:
    (tmp_path / "rclpy.py").write_text(rclpy)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=":")
    if "has not started" in said:
        monkeypatch.setattr(check, "_PROBE_S", 1.0)
    failed, _ = findings()
    assert failed.outcome is Outcome.FAIL
    assert said in failed.text
    assert failed.advice
