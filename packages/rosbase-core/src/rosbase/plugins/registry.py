"""The registry: finds the installed plugins; returns backends, transports and presets by name."""

import difflib
import sys
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from typing import Any, TypeVar, cast

import pluggy
from attrs import evolve

from rosbase.contracts.graph import type_name_of
from rosbase.contracts.message_format import MessageFormat
from rosbase.errors import NotInstalledError, PluginError
from rosbase.plugins import hookspec
from rosbase.plugins.descriptors import (
    BackendPlugin,
    CheckPlugin,
    CommandPlugin,
    ConversionPlugin,
    Descriptor,
    PresetPlugin,
    RecorderPlugin,
    TransportPlugin,
    conversion_name,
)
from rosbase.plugins.discovery import CORE, Candidate, find_candidates
from rosbase.plugins.loader import PluginRecord, Trace, load_plugin, words_of
from rosbase.plugins.our_packages import OURS, how_to_install
from rosbase.plugins.switches import BLOCK_VARIABLE, STRICT_VARIABLE, PluginSwitches
from rosbase.text.printable import log_line

__all__ = ["ENTRY_POINT_GROUP", "PluginRegistry", "installed_plugins"]

ENTRY_POINT_GROUP = "rosbase"

AcceptedT = TypeVar("AcceptedT")
DescriptorT = TypeVar("DescriptorT", bound=Descriptor)


class PluginRegistry:
    """The installed plugins, and their descriptors."""

    def __init__(
        self, candidates: Iterable[Candidate], switches: PluginSwitches | None = None
    ) -> None:
        """Load every candidate that is not blocked; none of them can make this fail.

        Args:
            candidates: Entry points that claim to be plugins.
            switches: Switches set by the user; by default none.

        Raises:
            ConfigurationError: The switches block the core.
            PluginError: One has failed, and the switches are strict.
        """
        self._switches = switches or PluginSwitches()
        self._plugins = _refuse_contested(_load(list(candidates), self._switches))
        self.check_strictly(self._plugins)
        self._by_kind: dict[str, dict[str, Descriptor]] = {}
        for record in self._plugins:
            for descriptor in record.descriptors:
                self._by_kind.setdefault(descriptor.kind, {})[descriptor.name] = descriptor

    @property
    def plugins(self) -> tuple[PluginRecord, ...]:
        """Plugins found, including failed ones, by distribution and name."""
        return self._plugins

    @property
    def backends(self) -> Mapping[str, BackendPlugin]:
        """Backends by name."""
        return self._of(BackendPlugin)

    @property
    def transports(self) -> Mapping[str, TransportPlugin]:
        """Usable transports by name."""
        return self._of(TransportPlugin)

    @property
    def presets(self) -> Mapping[str, PresetPlugin]:
        """Usable payload presets by name."""
        return self._of(PresetPlugin)

    @property
    def commands(self) -> Mapping[str, CommandPlugin]:
        """Commands of plugins by name."""
        return self._of(CommandPlugin)

    @property
    def checks(self) -> Mapping[str, CheckPlugin]:
        """Checks of `rosbase doctor` by name."""
        return self._of(CheckPlugin)

    def backend(self, name: str) -> BackendPlugin:
        """Return the backend of that name.

        Raises:
            NotInstalledError: There is none; the message says what is available and what to
                install.
        """
        return self._find(BackendPlugin, name)

    def transport(self, name: str) -> TransportPlugin:
        """Return the transport of that name.

        Raises:
            NotInstalledError: There is none; the message says what is available and what to
                install.
        """
        return self._find(TransportPlugin, name)

    def preset(self, name: str) -> PresetPlugin:
        """Return the payload preset of that name.

        Raises:
            NotInstalledError: There is none; the message says what is available.
        """
        return self._find(PresetPlugin, name)

    def command(self, name: str) -> CommandPlugin:
        """Return the command of that name.

        Raises:
            NotInstalledError: There is none; the message says what is available.
        """
        return self._find(CommandPlugin, name)

    def recorder(self, name: str) -> RecorderPlugin:
        """Return the recorder of files with that suffix.

        Raises:
            NotInstalledError: There is none; the message says what is available and what to
                install.
        """
        return self._find(RecorderPlugin, name)

    def message_format(self, msg_type: Any) -> MessageFormat:
        """Return the format of a class of messages that a backend knows, without opening it.

        Raises:
            TypeError: None of those that are installed knows it.
        """
        for plugin in self._of(BackendPlugin).values():
            if plugin.message_format is not None:
                try:
                    return plugin.message_format(msg_type)
                except (ImportError, NotInstalledError, TypeError):
                    # Its middleware may not be installed.
                    continue
        raise TypeError(f"{type_name_of(msg_type)} is not known without its middleware")

    def create_conversion(
        self, msg_type: type, backend: str, accept: Callable[[Any], AcceptedT]
    ) -> AcceptedT | None:
        """Return a plugin's conversion for messages of that class; None if no plugin has one.

        Args:
            msg_type: The class.
            backend: The name of the backend.
            accept: Converts it to the type that the backend works with; raises if it cannot.

        Raises:
            PluginError: More than one plugin claims the class, or its conversion is unusable.
        """
        name = conversion_name(msg_type, backend)
        found = self._of(ConversionPlugin).get(name)
        if found is None:
            if why := self._why_not(ConversionPlugin.kind, name):
                raise PluginError(why)
            return None
        try:
            return accept(found.create())
        except Exception as error:
            failed = f"{self.owner_of(found).full_name} failed: {words_of(error)}"
            raise PluginError(_says(found.kind, name, failed)) from error

    def owner_of(self, descriptor: Descriptor) -> PluginRecord:
        """Return the plugin that provides the descriptor."""
        return next(record for record in self._plugins if descriptor in record.descriptors)

    def check_strictly(self, records: Iterable[PluginRecord]) -> None:
        """Refuse failed plugins, if the user has asked for that.

        Raises:
            PluginError: One has failed, and `ROSBASE_STRICT_PLUGINS` is set; the message names
                all.
        """
        failed = [f"{r.full_name} failed: {r.failure}" for r in records if r.status == "failed"]
        if failed and self._switches.is_strict:
            raise PluginError(f"{'; '.join(failed)} ({STRICT_VARIABLE} is set)")

    @property
    def missing(self) -> Mapping[str, str]:
        """Return the parts of this project that are not installed, as package by part."""
        packages = {record.distribution for record in self._plugins}
        return {
            f"{kind} '{name}'": package
            for (kind, name), package in OURS.items()
            if kind != CheckPlugin.kind and package not in packages
        }

    @staticmethod
    def is_ours(kind: str, name: str) -> bool:
        """Return whether the name belongs to a package of this project."""
        return (kind, name) in OURS

    def _of(self, kind: type[DescriptorT]) -> Mapping[str, DescriptorT]:
        return cast(Mapping[str, DescriptorT], self._by_kind.get(kind.kind, {}))

    def _find(self, kind: type[DescriptorT], name: str) -> DescriptorT:
        found = self._of(kind).get(name)
        if found is None:
            raise NotInstalledError(self._explain(kind.kind, name))
        return found

    def _explain(self, kind: str, name: str) -> str:
        if why := self._why_not(kind, name):
            return why
        package = OURS.get((kind, name))
        if package:
            return f"{kind} '{name}' needs the package {package}; {how_to_install(package)}"
        installed = sorted(self._by_kind.get(kind, {}))
        near = difflib.get_close_matches(name, installed, n=1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        blocked = ", ".join(record.full_name for record in self._plugins if record.is_blocked)
        # Nobody knows what they would bring.
        unseen = f"; blocked by {BLOCK_VARIABLE}: {blocked}" if blocked else ""
        return f"no {kind} '{name}'; installed: {', '.join(installed) or 'none'}{unseen}{hint}"

    def _why_not(self, kind: str, name: str) -> str:
        """Return which failed or blocked plugin should have the name; empty if none does."""
        package = OURS.get((kind, name))
        for record in self._plugins:
            is_owner = record.distribution == package
            # What it would bring is often not known: it has not been imported.
            is_likely = name.partition(".")[0] in (record.name, record.candidate.package)
            if record.failure and (is_owner or is_likely or f"'{name}'" in record.failure):
                return _says(kind, name, f"{record.full_name} failed: {record.failure}")
            if record.is_blocked and (is_owner or is_likely):
                return _says(kind, name, f"{record.full_name} is blocked by {BLOCK_VARIABLE}")
        return ""


def _load(candidates: list[Candidate], switches: PluginSwitches) -> list[PluginRecord]:
    """Return the record of each candidate, before they are compared with each other."""
    manager = pluggy.PluginManager(hookspec.PROJECT_NAME)
    manager.add_hookspecs(hookspec)
    blocked = switches.choose_blocked(candidates)
    return [
        PluginRecord(candidate, is_blocked=True)
        if candidate.full_name in blocked
        else load_plugin(manager, candidate, _trace_of(candidate, switches))
        for candidate in candidates
    ]


def _trace_of(candidate: Candidate, switches: PluginSwitches) -> Trace:
    def trace(line: str) -> None:
        if switches.traces:
            try:
                text = log_line(f"rosbase hooks: {candidate.full_name} {line}")
                print(text, file=sys.stderr)
            except OSError:
                # That nobody can hear it is no fault of the plugin.
                pass

    return trace


def _says(kind: str, name: str, why: str) -> str:
    return f"{kind} '{name}' cannot be used: {why}"


def _refuse_contested(records: list[PluginRecord]) -> tuple[PluginRecord, ...]:
    """Fail every plugin that claims a name which another one has too.

    A name of this project stays with its package, and a name of the core with the core.
    Between others there is no right one, so neither is used, and the user sees both.
    """
    claims: dict[tuple[str, str], list[PluginRecord]] = {}
    for record in records:
        for descriptor in record.descriptors:
            claims.setdefault((descriptor.kind, descriptor.name), []).append(record)
    failures: dict[str, str] = {}
    for (kind, name), claimants in claims.items():
        core = any(record.candidate.is_core for record in claimants)
        owner = OURS.get((kind, name), CORE if core else "")
        others = [record for record in claimants if record.distribution != owner]
        if owner and len(others) == len(claimants):
            failures |= {r.full_name: f"{kind} '{name}' is reserved for {owner}" for r in others}
        elif len(claimants) > 1:
            who = " and ".join(sorted({record.full_name for record in claimants}))
            reason = f"{kind} '{name}' is claimed by {who}"
            failures |= {record.full_name: reason for record in others or claimants}
    return tuple(
        evolve(record, descriptors=(), failure=failures[record.full_name])
        if record.full_name in failures
        else record
        for record in records
    )


@cache
def installed_plugins() -> PluginRegistry:
    """Return the registry of this process.

    It is loaded on first use, with the switches in the environment.

    Raises:
        ConfigurationError: The environment has invalid switches.
        PluginError: A plugin has failed, and `ROSBASE_STRICT_PLUGINS` is set.
    """
    return PluginRegistry(find_candidates(ENTRY_POINT_GROUP), PluginSwitches.from_environment())
