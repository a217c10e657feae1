"""LeRobot data sets made of bags, episode by episode."""
