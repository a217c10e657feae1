"""``launch --watch``: what is saved is started again, see `watch`."""
