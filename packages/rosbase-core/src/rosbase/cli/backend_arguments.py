"""Command-line arguments for the backend, such as those after `--ros-args`."""

from collections.abc import Mapping, Sequence

from rosbase.errors import ConfigurationError
from rosbase.plugins import BackendPlugin

__all__ = ["check_taken", "split_arguments"]

_END = "--"


def split_arguments(
    arguments: Sequence[str], backends: Mapping[str, BackendPlugin]
) -> tuple[list[str], dict[str, str], list[str]]:
    """Split a command line into the command's own arguments and those for backends.

    The arguments of a backend follow its word, up to `--` or the end. The backend finds them
    by itself.

    Returns:
        The remaining arguments, each word that was found with the name of its backend, and the
        arguments of the backends with these words.
    """
    words = {plugin.arguments_after: name for name, plugin in backends.items()}
    own: list[str] = []
    found: dict[str, str] = {}
    theirs: list[str] = []
    within = False
    for argument in arguments:
        if argument and argument in words:
            found[argument] = words[argument]
            within = True
        (theirs if within else own).append(argument)
        within = within and argument != _END
    return own, found, theirs


def check_taken(found: Mapping[str, str], backend: str) -> None:
    """Ensure that no argument is silently ignored.

    Raises:
        ConfigurationError: There are arguments of a backend that is not the chosen one.
    """
    for word, name in found.items():
        if name != backend:
            raise ConfigurationError(
                f"arguments after {word} are for the backend {name}, but this is {backend}:"
                f" add --backend {name}"
            )
