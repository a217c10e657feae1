"""What a launch description is, and the plan that it becomes: plain data, whoever wrote it."""
