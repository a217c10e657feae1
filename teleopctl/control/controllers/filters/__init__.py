"""Filters of measured values, as in ``filters`` and ``control_filters``."""
