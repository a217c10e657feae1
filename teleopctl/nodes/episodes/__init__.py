"""Recording of episodes, demonstrations of a task: a bag each, added to a data set."""
