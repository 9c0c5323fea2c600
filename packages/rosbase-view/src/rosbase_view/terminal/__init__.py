"""The view on textual: widgets that show the lines of the model, and keys."""
