"""What a launch asks of nodes by their services, beside its processes."""
