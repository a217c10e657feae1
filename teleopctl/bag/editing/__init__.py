"""Bags made of bags: copied, cut, merged, converted, checked, recovered and reindexed."""
