"""Text and pictures in the cells of a terminal. Pure."""
