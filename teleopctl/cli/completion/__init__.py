"""What Tab offers, and how the shells ask for it."""
