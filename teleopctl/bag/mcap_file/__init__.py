"""MCAP files of a bag: written so that a crash loses little, read, checked and completed."""
