"""Types as others define them: a node by its description, a bag by its text."""
