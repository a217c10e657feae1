"""What MoveIt plans: states, trajectories and the planning scene, as its plug-ins of RViz show."""
