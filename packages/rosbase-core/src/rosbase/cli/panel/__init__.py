"""The live panel of a run on a terminal: text in, lines that fit the width out."""
