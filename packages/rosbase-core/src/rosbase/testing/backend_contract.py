"""Conformance kit for backends: subclass `BackendContract` and implement `make_backend`.

```
class TestMyBackend(BackendContract):
    capabilities = BackendCapabilities(several_per_process=True)

    def make_backend(self, options: BackendOptions) -> Backend:
        return MyBackend(options)
```

Each test checks one promise and has its name (`rosbase.testing.backend_kit.promises`). A failure
shows the promise, what the test saw instead, and the page about it.
"""

from rosbase.testing.backend_kit.ending import EndingChecks
from rosbase.testing.backend_kit.opening import OpeningChecks
from rosbase.testing.backend_kit.parameters import ParameterChecks
from rosbase.testing.backend_kit.promises import PROMISES
from rosbase.testing.backend_kit.quality import QualityChecks
from rosbase.testing.backend_kit.rig import BackendCapabilities, ServiceKind
from rosbase.testing.backend_kit.services import ServiceChecks
from rosbase.testing.backend_kit.taps import TapChecks
from rosbase.testing.backend_kit.threads import ThreadChecks
from rosbase.testing.backend_kit.timers import TimerChecks
from rosbase.testing.backend_kit.topics import TopicChecks

__all__ = ["BackendCapabilities", "BackendContract", "ServiceKind"]


class BackendContract(
    OpeningChecks,
    ThreadChecks,
    TopicChecks,
    TapChecks,
    QualityChecks,
    TimerChecks,
    ParameterChecks,
    ServiceChecks,
    EndingChecks,
):
    """All checks of a backend. pytest runs a subclass whose name begins with `Test`.

    Must define: `make_backend(self, options)`.

    May define: `capabilities`, for the optional capabilities of the backend; `make_peer`,
    if another backend of the same world is made in a different way; `service_kind`, if it cannot
    send classes of Python; `patience_s`, on slow machines.
    """


for _name, _promise in PROMISES.items():
    # pytest shows it if a backend raises an unexpected exception.
    getattr(BackendContract, f"test_{_name.replace('-', '_')}").promise = _promise
