"""The transport `mqtt` for rosbase: an IMU that sends JSON to an MQTT broker."""
