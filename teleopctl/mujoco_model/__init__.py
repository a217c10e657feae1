"""From a robot description to a ``mujoco.MjSpec``, for whoever simulates, draws or solves.

What needs the model needs no simulation: the camera, kinematics and the page take it from here.
"""
