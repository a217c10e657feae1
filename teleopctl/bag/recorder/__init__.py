"""Records topics of the graph into a bag."""
