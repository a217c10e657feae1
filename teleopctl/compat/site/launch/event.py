"""``launch.event``."""


class Event:
    """Something that happens while a launch runs.

    Attributes:
        name: Its name, with dots.
    """

    name = "launch.Event"
