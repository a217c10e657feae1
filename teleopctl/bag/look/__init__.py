"""Bags looked at: as tables, films and plots. Decodes, by the definitions that the bag carries."""
