"""Start a node in a child process, and print the result as one line of JSON.

rcl and its middleware may end the process, for example because of an environment variable.
"""

import json

from rosbase_ros2.imports import explain

__all__ = ["main"]


def main() -> None:
    """Print which middleware carries the node, or what is wrong."""
    try:
        import rclpy  # noqa: F401, PLC0415 - whether it can be is the question
    except Exception as error:
        _say(rclpy_failure=explain(error))
        return
    try:
        _say(middleware=_start_a_node())
    except Exception as error:
        _say(failure=str(error) or type(error).__name__)


def _start_a_node() -> str:
    # Only here, so that what is missing is said. The backend brings in all messages that it sends.
    from rclpy.utilities import get_rmw_implementation_identifier  # noqa: PLC0415 - see above

    from rosbase import BackendOptions  # noqa: PLC0415 - see above
    from rosbase_ros2.backend import Ros2Backend  # noqa: PLC0415 - see above

    Ros2Backend(BackendOptions("rosbase_doctor")).close()
    name: str = get_rmw_implementation_identifier()
    return name


def _say(**found: str) -> None:
    print(json.dumps(found), flush=True)
