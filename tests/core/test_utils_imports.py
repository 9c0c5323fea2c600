"""`rosbase.utils` imports little, and needs no numpy."""

import subprocess
import sys

import pytest

import rosbase.utils

WITHOUT_NUMPY = """
import math, sys
sys.modules["numpy"] = None
from rosbase.utils import *
assert quat_to_rpy(rpy_to_quat(0.0, math.pi / 2, 0.0))[1] == math.pi / 2
assert quat_rotate_inverse((1, 0, 0, 0), (1, 2, 3)) == (1.0, 2.0, 3.0)
assert trans_opt_to_ros_frame(trans_ros_frame_to_opt_frame((1, 2, 3))) == (1.0, 2.0, 3.0)
assert warp2pi(-math.pi) == math.pi
history, smooth = CircularBuffer(2), VectorLPFilter(0.01, 5.0)
history.append([1.0])
smooth.update([1.0, 2.0, 3.0])
print(history.buffer, smooth.get_values())
"""


def run(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code],
        capture_output=True, text=True, timeout=30, check=True,
    )  # fmt: skip
    return done.stdout


def test_all_works_where_numpy_is_not_installed() -> None:
    assert run(WITHOUT_NUMPY) == "((1.0,), (1.0,)) (1.0, 2.0, 3.0)\n"


def test_numpy_is_not_imported_where_it_is_installed() -> None:
    code = "import sys; from rosbase.utils import *; warp2pi(4.0); print('numpy' in sys.modules)"
    assert run(code) == "False\n"


def test_a_name_is_imported_when_it_is_first_used() -> None:
    code = (
        "import sys, rosbase.utils; print('rosbase.utils.angles' in sys.modules);"
        "rosbase.utils.warp2pi; print('rosbase.utils.angles' in sys.modules, dir(rosbase.utils))"
    )
    assert run(code) == f"False\nTrue {rosbase.utils.__all__}\n"


def test_a_name_that_does_not_exist_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="warp3pi"):
        rosbase.utils.warp3pi  # type: ignore[attr-defined]  # noqa: B018 - the import is the test
    for name in rosbase.utils.__all__:
        assert getattr(rosbase.utils, name).__name__ == name
