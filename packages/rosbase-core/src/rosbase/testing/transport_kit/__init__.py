"""Parts of `rosbase.testing.transport_contract`."""
