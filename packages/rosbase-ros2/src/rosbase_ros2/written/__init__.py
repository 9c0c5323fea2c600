"""Values in parameter files and after `-p`, before YAML guesses their types."""

from rosbase_ros2.written.arguments import RosArguments
from rosbase_ros2.written.guess import is_guess_of

__all__ = ["RosArguments", "is_guess_of"]
