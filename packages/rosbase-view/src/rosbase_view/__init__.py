"""Views of running rosbase programs.

`known` and `view` are the model, with `pages` and `drawing`: pure, and without a terminal library.
A `source` feeds the model; `attached` is the one for running programs. `terminal` shows the model
on textual.
"""
