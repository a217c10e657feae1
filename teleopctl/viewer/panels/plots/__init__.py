"""What the plot panel is made of."""
