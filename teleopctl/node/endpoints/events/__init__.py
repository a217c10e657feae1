"""Events of publishers and subscriptions, each counted by a handler of its own."""
