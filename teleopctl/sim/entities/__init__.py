"""What is in a simulation by name, and the standard services that ask for it and change it."""
