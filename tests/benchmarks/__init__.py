"""Benchmarks: ``pytest tests/benchmarks`` prints one table of ratios.

Each benchmark also runs its floor (raw Zenoh, raw MuJoCo, a bare interpreter) in the same minute,
so that ratios of different machines are comparable. No benchmark fails because it is slow.
"""
