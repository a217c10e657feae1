"""Plays bags into the graph: read ahead, paced by a time line, published as bytes."""
