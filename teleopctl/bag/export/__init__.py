"""Exports of bags: tables, videos, plots and LeRobot data sets, from decoded messages.

Messages are decoded by the type definitions in the bag.
"""
