"""`local` keeps the contract of backends."""

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.local import LocalBackend
from rosbase.testing import BackendCapabilities, BackendContract


class TestLocalBackend(BackendContract):
    capabilities = BackendCapabilities(
        delivers_in_process=True,
        several_per_process=True,
        takes_a_clock=True,
        has_services=True,
        has_taps=True,
    )

    def make_backend(self, options: BackendOptions) -> Backend:
        return LocalBackend(options)
