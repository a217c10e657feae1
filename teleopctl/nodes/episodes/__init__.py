"""Recording of episodes: tries at a task, each a bag, from which a data set grows."""
