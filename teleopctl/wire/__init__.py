"""Floor 1: the wire format of rmw_zenoh on Eclipse Zenoh."""
