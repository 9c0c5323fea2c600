"""The source of a recording: what plays it, and how it is read."""
