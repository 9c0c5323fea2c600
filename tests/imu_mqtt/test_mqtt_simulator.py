"""The embedded broker of simulated devices."""

import asyncio
import gc

import pytest
from amqtt.errors import ProtocolHandlerError

from imu_mqtt.simulator import EmbeddedBroker
from support.waiting import wait_until


@pytest.mark.parametrize(
    ("error", "is_reported"),
    [
        (ProtocolHandlerError("Packet handling was cancelled"), False),
        (ConnectionResetError("Connection lost"), False),
        (RuntimeError("a fault of the broker"), True),
    ],
)
def test_a_client_that_goes_while_it_is_answered_is_not_reported(
    embedded: EmbeddedBroker,
    error: Exception,
    is_reported: bool,
    caplog: pytest.LogCaptureFixture,
) -> None:
    async def answer() -> None:
        raise error

    async def begin() -> None:
        # As amqtt does: nobody asks for the result.
        task = asyncio.ensure_future(answer())
        await asyncio.wait([task])

    asyncio.run_coroutine_threadsafe(begin(), embedded._loop).result(20)

    def is_said() -> bool:
        gc.collect()
        return "Task exception was never retrieved" in caplog.text

    if is_reported:
        wait_until(is_said, "the report")
    else:
        embedded.close()
        assert not is_said()
