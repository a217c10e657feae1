"""Parameters of a node, parameter services, and clients of other nodes' parameters."""
