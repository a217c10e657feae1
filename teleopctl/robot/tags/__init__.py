"""Which tags and attributes descriptions may have, and what becomes of each."""
