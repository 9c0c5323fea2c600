"""Checks of samples: each compares them with a known fact, and reports contradictions."""
