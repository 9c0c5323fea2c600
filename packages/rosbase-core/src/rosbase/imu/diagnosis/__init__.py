"""What a frame that was refused is, if it is not what a reader takes. For those that are logged."""
