"""Explanations of the counts, for `--help`."""

__all__ = ["COUNTS_HELP"]

COUNTS_HELP = """\
what the counts mean:
  sent        samples that the simulated device sent
  received    messages that the reader got: lines of a serial port, payloads of a topic
  published   samples published on imu/data, imu/data_raw or imu/mag
  rejected    messages that should have been samples but were unusable; the reasons follow
  ignored     messages that are not samples of this device, such as its boot messages
  dropped     samples that were published, but did not get to the subscriber in time
  lost        messages that were sent but never received
  reconnects  how often the device was lost and came back
"""
