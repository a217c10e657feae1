"""Runs of a sweep on several machines, which Dask brings them to."""
