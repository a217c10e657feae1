"""Player of bags: reads ahead, waits for each message's time, publishes messages undecoded."""
