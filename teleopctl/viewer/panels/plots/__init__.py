"""Panel of plots: fields and expressions of messages over time."""
