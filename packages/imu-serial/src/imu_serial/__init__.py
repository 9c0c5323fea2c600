"""Serial ports for rosbase: the transport `serial`."""
