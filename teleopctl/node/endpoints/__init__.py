"""What a node talks through: publishers, subscriptions, services, clients, timers, events."""
