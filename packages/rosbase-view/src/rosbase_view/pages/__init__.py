"""The pages of the view, one for each subject. Pure: what is known in, lines out."""
