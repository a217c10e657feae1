"""Actions of launch files: one class for each kind of entry."""
