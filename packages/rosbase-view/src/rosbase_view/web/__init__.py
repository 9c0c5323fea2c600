"""View in a browser: the board in 3-D, plots, health and buttons, on viser.

Only `server`, `scene` and `panel` touch viser. Everything else is pure, or runs the loop.
"""
