"""A session as a data set of LeRobot: what is sampled, its statistics, its files."""
