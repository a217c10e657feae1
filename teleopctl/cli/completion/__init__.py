"""Tab completion: candidates for each word, and scripts for the shells."""
