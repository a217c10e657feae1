"""Player of bags: reads ahead, paces by playback time, publishes messages undecoded."""
