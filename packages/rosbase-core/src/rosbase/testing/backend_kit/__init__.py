"""The parts of `rosbase.testing.backend_contract`, by what they check."""
