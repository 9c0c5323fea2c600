"""Choose the programs that start: disabled beats enabled, which beats `autostart`."""

from collections.abc import Iterable, Sequence

from rosbase.errors import ConfigurationError
from rosbase.launcher.description import Program
from rosbase.parameters.checking import did_you_mean
from rosbase.text.printable import printable

__all__ = ["choose"]


def choose(
    programs: Sequence[Program], enable: Iterable[str] = (), disable: Iterable[str] = ()
) -> list[str]:
    """Return the keys of the programs that start.

    Args:
        programs: All programs.
        enable: Names or keys of programs that start whatever their `autostart` says.
        disable: Names or keys of programs that do not start, even if they are enabled.

    Raises:
        ConfigurationError: No program has one of the names.
    """
    enabled, disabled = _keys(programs, enable), _keys(programs, disable)
    return [
        program.key
        for program in programs
        if program.key not in disabled and (program.autostart or program.key in enabled)
    ]


def _keys(programs: Sequence[Program], names: Iterable[str]) -> set[str]:
    found: set[str] = set()
    for name in names:
        keys = {program.key for program in programs if name in (program.key, program.name)}
        if not keys:
            known = [program.key for program in programs]
            hint = did_you_mean(name, known) or f"; there are {', '.join(known)}"
            raise ConfigurationError(f"no program is called '{printable(name)}'{hint}")
        found |= keys
    return found
