"""Verbs that work on the files of bags; none needs a node or a router."""
