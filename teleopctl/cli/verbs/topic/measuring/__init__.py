"""``topic hz``, ``bw`` and ``delay``: what they count, and how they show it."""
