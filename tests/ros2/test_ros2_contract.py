"""`ros2` keeps the contract of backends."""

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.testing import BackendCapabilities, BackendContract
from rosbase_ros2.backend import Ros2Backend


class TestRos2Backend(BackendContract):
    capabilities = BackendCapabilities(several_per_process=True, has_log_handler=True)

    def make_backend(self, options: BackendOptions) -> Backend:
        return Ros2Backend(options)
