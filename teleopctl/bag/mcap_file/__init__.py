"""One MCAP file: written so that a crash loses little, read whole or not, finished afterwards."""
