"""Tests; a package so that they share helpers by name."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
