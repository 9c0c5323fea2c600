"""What `rosbase.testing.transport_contract` is made of."""
