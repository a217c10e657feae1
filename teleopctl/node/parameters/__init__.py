"""Parameters: values, files, what a node keeps of them, and its dealings with other nodes'."""
