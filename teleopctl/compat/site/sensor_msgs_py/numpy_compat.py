"""``sensor_msgs_py.numpy_compat``. What NumPy has under other names where it is old."""

from numpy.lib.recfunctions import structured_to_unstructured, unstructured_to_structured

__all__ = ["structured_to_unstructured", "unstructured_to_structured"]
