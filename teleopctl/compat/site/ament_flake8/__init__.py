"""``ament_flake8``. Checks of Python code by flake8's rules, done by Ruff."""
