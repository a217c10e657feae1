"""Check of a robot file: reading, repairs, model, simulation, controllers and frames."""
