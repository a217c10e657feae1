"""What is measured, and never judged: ``pytest -s tests/benchmarks`` prints ratios.

Each benchmark runs its floor (raw Zenoh, raw MuJoCo, a bare interpreter) beside ours in the same
minute, so that a ratio means the same on every machine. Nothing here fails for being slow.
"""
