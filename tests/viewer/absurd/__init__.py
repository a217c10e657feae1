"""Absurd files and messages: shown as far as possible, and one warning says what is not."""
