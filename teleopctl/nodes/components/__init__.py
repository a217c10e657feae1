"""Component containers, and the components that they find with teleopctl."""
