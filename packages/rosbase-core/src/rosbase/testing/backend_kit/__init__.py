"""Parts of `rosbase.testing.backend_contract`, by subject."""
