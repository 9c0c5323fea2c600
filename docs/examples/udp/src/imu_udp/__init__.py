"""UDP for rosbase."""
