"""Floor 6: the verbs of the command line, one module per command group."""
