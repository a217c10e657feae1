"""What panels ask of other nodes: services, controller managers, whom the sliders move."""
