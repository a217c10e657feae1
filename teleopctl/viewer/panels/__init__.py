"""The tabs beside the picture: one file for each."""
