"""Bags from bags: chosen, cut, merged and converted; looked through and repaired."""
