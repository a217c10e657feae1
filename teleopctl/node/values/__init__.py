"""Building blocks without a node: names, times, QoS, parameters, futures, logging."""
