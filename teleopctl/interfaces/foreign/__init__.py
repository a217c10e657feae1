"""Types defined elsewhere: by a node's type description, a bag's definition texts, or IDL."""
