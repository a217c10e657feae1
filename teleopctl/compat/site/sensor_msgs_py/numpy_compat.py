"""``sensor_msgs_py.numpy_compat``. Compatibility with old versions of NumPy."""

from numpy.lib.recfunctions import structured_to_unstructured, unstructured_to_structured

__all__ = ["structured_to_unstructured", "unstructured_to_structured"]
