"""Creation of bags from other bags: copy, cut, merge, convert, check, recover and reindex."""
