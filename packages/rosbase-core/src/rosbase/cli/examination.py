"""Run checks side by side, so that one which raises or hangs does not affect the others."""

from collections.abc import Iterator

from rosbase.contracts.checks import CheckContext, Finding, Outcome
from rosbase.errors import PluginError
from rosbase.plugins import BLOCK_VARIABLE, CheckPlugin, PluginRecord, PluginRegistry
from rosbase.runtime.signal_masks import background_thread

__all__ = ["examine"]


def examine(
    registry: PluginRegistry, context: CheckContext, limit_s: float
) -> Iterator[tuple[str, Finding]]:
    """Yield the name of a check and a finding, the core's checks first.

    Args:
        registry: Registry with the checks.
        context: Context for each check.
        limit_s: Time limit for all checks together.
    """
    checks = list(registry.checks.values())
    runs = [_Run(check, registry.owner_of(check), context) for check in checks]
    runs.sort(key=lambda run: not run.owner.candidate.is_core)
    deadline_ns = context.clock.monotonic_ns() + int(limit_s * 1e9)
    for run in runs:
        left_s = (deadline_ns - context.clock.monotonic_ns()) / 1e9
        for finding in run.findings(max(left_s, 0.0), limit_s):
            yield run.name, finding


class _Run:
    """A running check, on its own thread."""

    def __init__(self, check: CheckPlugin, owner: PluginRecord, context: CheckContext) -> None:
        self.name = check.name
        self.owner = owner
        self._check = check
        self._context = context
        self._found: list[Finding] = []
        # A daemon: one that hangs must not keep the process.
        self._thread = background_thread(self._run, f"check-{check.name}")
        self._thread.start()

    def findings(self, timeout_s: float, limit_s: float) -> list[Finding]:
        """Return its findings; report that it hangs if it does not end in time."""
        self._thread.join(timeout_s)
        found = list(self._found)
        if self._thread.is_alive():
            found.append(self._blame(f"the check has not ended within {limit_s:g} s"))
        return found

    def _run(self) -> None:
        try:
            for finding in self._check.run(self._context):
                if not isinstance(finding, Finding):
                    raise PluginError(f"it must yield Finding, not {type(finding).__name__}")
                self._found.append(finding)
        except BaseException as error:
            # Base: a library may call sys.exit().
            self._found.append(self._blame(f"the check failed: {type(error).__name__}: {error}"))

    def _blame(self, text: str) -> Finding:
        owner = self.owner
        return Finding(
            Outcome.FAIL,
            text,
            f"report it to the authors of {owner.distribution} {owner.version};"
            f" {BLOCK_VARIABLE}={owner.full_name} leaves it out",
        )
