"""Evaluation of launch files: substitutions, scopes and parameters, to a plan of processes."""
