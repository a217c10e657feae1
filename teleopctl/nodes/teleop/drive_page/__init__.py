"""The page ``/drive``: a robot is driven by keys, touch pads or a gamepad in a browser."""
