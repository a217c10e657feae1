"""Servo: streams of twists, poses and joint velocities as safe steps of the joints.

Classes without node or clock: state, command and period in, joint command and reasons out.
"""
