"""The IMU reader: payload mapping, the lifecycle node that publishes, and a simulator."""
