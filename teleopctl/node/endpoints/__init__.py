"""Publishers, subscriptions, services, clients, timers, guard conditions and their events."""
