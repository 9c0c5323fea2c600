"""What stands in parameter files and behind `-p`, before YAML guesses its type."""

from rosbase_ros2.written.arguments import RosArguments
from rosbase_ros2.written.guess import is_guess_of

__all__ = ["RosArguments", "is_guess_of"]
