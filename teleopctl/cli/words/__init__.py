"""Words of a command line, and what they may mean: numbers, names, types, values of messages."""
