"""The planning scene: objects around a robot and in its hand, and which bodies may touch.

Numbers in, numbers out, as a MuJoCo model with a geom for each shape; no node and no message.
"""
