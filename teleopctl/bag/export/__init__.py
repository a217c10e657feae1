"""Exports of bags: tables, videos, plots and LeRobot data sets, from decoded messages.

Decodes, by the definitions that the bag carries.
"""
