"""``ament_pep257``. Checks of docstrings by PEP 257, done by Ruff."""
