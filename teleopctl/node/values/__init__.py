"""What a node is made of that needs no node: names, times, QoS, parameters, futures, logging."""
