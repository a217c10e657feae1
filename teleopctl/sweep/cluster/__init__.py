"""Runs of a sweep on several machines, distributed by Dask."""
