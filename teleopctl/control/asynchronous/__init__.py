"""Controllers and hardware components that run in threads of their own (``is_async``)."""
