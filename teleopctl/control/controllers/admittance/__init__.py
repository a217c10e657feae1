"""Admittance controller: joints that give way to measured forces."""
