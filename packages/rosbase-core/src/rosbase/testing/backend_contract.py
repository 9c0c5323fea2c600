"""The backend contract as tests: subclass it, say how a backend is made, and run pytest.

```
class TestMyBackend(BackendContract):
    capabilities = BackendCapabilities(several_per_process=True)

    def make_backend(self, options: BackendOptions) -> Backend:
        return MyBackend(options)
```

Each test checks one promise, which has its name (`rosbase.testing.backend_kit.promises`). One that
fails says what was promised, what was seen instead, and where more is written about it.
"""

from rosbase.testing.backend_kit.ending import EndingChecks
from rosbase.testing.backend_kit.opening import OpeningChecks
from rosbase.testing.backend_kit.parameters import ParameterChecks
from rosbase.testing.backend_kit.promises import PROMISES
from rosbase.testing.backend_kit.quality import QualityChecks
from rosbase.testing.backend_kit.rig import BackendCapabilities
from rosbase.testing.backend_kit.threads import ThreadChecks
from rosbase.testing.backend_kit.timers import TimerChecks
from rosbase.testing.backend_kit.topics import TopicChecks

__all__ = ["BackendCapabilities", "BackendContract"]


class BackendContract(
    OpeningChecks,
    ThreadChecks,
    TopicChecks,
    QualityChecks,
    TimerChecks,
    ParameterChecks,
    EndingChecks,
):
    """All checks of a backend. A subclass whose name begins with `Test` is run by pytest.

    Must define: `make_backend(self, options)`.

    May define: `capabilities`, for whatever the backend can that not every one can; `make_peer`,
    where another backend of the same world is made otherwise; `patience_s`, on slow machines.
    """


for _name, _promise in PROMISES.items():
    # pytest shows it where a backend raises what nobody expects.
    getattr(BackendContract, f"test_{_name.replace('-', '_')}").promise = _promise
