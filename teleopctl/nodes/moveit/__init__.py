"""MoveIt's programs: servo."""
