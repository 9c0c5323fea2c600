"""`ros2` keeps the contract of backends."""

from typing import Any

import pytest
from rcl_interfaces.msg import ListParametersResult as RosResult
from rcl_interfaces.srv import ListParameters as RosListParameters

from rosbase.contracts.backend import Backend, BackendOptions
from rosbase.messages.rcl_interfaces import ListParameters, ListParametersResult
from rosbase.testing import BackendCapabilities, BackendContract
from rosbase.testing.backend_kit.rig import ServiceKind
from rosbase.testing.backend_kit.services import ServiceChecks
from rosbase_ros2 import services
from rosbase_ros2.backend import Ros2Backend

CAPABILITIES = BackendCapabilities(
    several_per_process=True, has_log_handler=True, has_services=True, has_taps=True
)


def number(message: Any) -> int:
    """The number that a request or an answer carries."""
    found = message.result.names[0] if hasattr(message, "result") else message.depth
    return int(found)


class TestRos2Backend(BackendContract):
    capabilities = CAPABILITIES
    service_kind = ServiceKind(
        ListParameters,
        lambda number: ListParameters.Request(depth=number),
        lambda number: ListParameters.Response(ListParametersResult(names=(str(number),))),
        number,
    )

    def make_backend(self, options: BackendOptions) -> Backend:
        return Ros2Backend(options)


class TestServicesOfRosTypes(ServiceChecks):
    capabilities = CAPABILITIES
    service_kind = ServiceKind(
        RosListParameters,
        lambda number: RosListParameters.Request(depth=number),
        lambda number: RosListParameters.Response(result=RosResult(names=[str(number)])),
        number,
    )

    def make_backend(self, options: BackendOptions) -> Backend:
        return Ros2Backend(options)


class TestServicesOverTheNetwork(ServiceChecks):
    """As if the two ends were in different processes."""

    capabilities = CAPABILITIES
    service_kind = TestRos2Backend.service_kind

    def make_backend(self, options: BackendOptions) -> Backend:
        return Ros2Backend(options)


@pytest.fixture(autouse=True)
def placed(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.cls is TestServicesOverTheNetwork:
        monkeypatch.setattr(services.Services, "_find", lambda self, key: None)
