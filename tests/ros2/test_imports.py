"""What is said where rclpy cannot be used. The missing and the broken one are played."""

import builtins
import sys
from typing import Any

import pytest

from rosbase.errors import NotInstalledError
from rosbase_ros2.imports import check_rclpy
from support.command import run_rosbase


def test_rclpy_from_the_package_index_is_fine() -> None:
    check_rclpy()


def test_a_missing_rclpy_is_one_line_that_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy", None)
    with pytest.raises(NotInstalledError, match=r"pip install.*fastrtps") as caught:
        check_rclpy()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["rmw_zenoh_cpp", "no such thing"])
def test_a_middleware_that_is_named_and_not_there_is_one_line(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", name)
    done = run_rosbase("imu", "--backend", "ros2")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert f"RMW_IMPLEMENTATION is {name}" in done.stderr


def test_a_middleware_that_is_named_and_there_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp")
    check_rclpy()


# What the wheels say, on a Python that they were not built for, and without their extra.
OTHER_PYTHON = ModuleNotFoundError(
    "No module named 'rclpy._rclpy_pybind11'\nThe C extension 'x.so' isn't present on the system",
    name="rclpy._rclpy_pybind11",
)
NO_MIDDLEWARE = ImportError(
    "librmw_fastrtps_cpp.so: cannot open shared object file: No such file or directory\n"
    "The C extension 'x.so' failed to be imported while being present on the system"
)


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (OTHER_PYTHON, f"by Python {sys.version_info.major}.{sys.version_info.minor};"),
        (NO_MIDDLEWARE, r"no middleware: pip install.*fastrtps"),
    ],
)
def test_a_broken_rclpy_is_one_line_that_says_what_is_wrong(
    monkeypatch: pytest.MonkeyPatch, error: ImportError, said: str
) -> None:
    real_import = builtins.__import__

    def broken(name: str, *args: Any) -> Any:
        if name == "rclpy":
            raise error
        return real_import(name, *args)

    monkeypatch.setattr(builtins, "__import__", broken)
    with pytest.raises(NotInstalledError, match=said) as caught:
        check_rclpy()
    assert "\n" not in str(caught.value)
