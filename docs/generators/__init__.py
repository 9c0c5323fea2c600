"""What the pages of the site show that is made from the code, and how docstrings become pages."""
