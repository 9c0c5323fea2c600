"""Diagnose refused frames that a reader cannot use. Only for frames that are logged."""
