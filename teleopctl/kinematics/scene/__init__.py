"""Planning scene: objects around a robot or attached to it, and allowed collisions.

Numbers in, numbers out, as a MuJoCo model with a geom for each shape; no node and no message.
"""
