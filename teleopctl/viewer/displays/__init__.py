"""What can be shown in the picture: one file for each kind of display, under RViz's names."""
