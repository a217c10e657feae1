"""A plan carried out: processes started, watched, shown and stopped."""
