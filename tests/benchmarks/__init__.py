"""Measurements, without judgement: ``pytest tests/benchmarks`` prints one table of ratios.

Each benchmark runs its floor (raw Zenoh, raw MuJoCo, a bare interpreter) in the same minute, so
that a ratio means the same on every machine. Nothing here fails for being slow.
"""
