"""``teleopctl python``: the Python interpreter with ROS 2's packages importable."""

import sys

from teleopctl.base.typed import Annotated
from teleopctl.cli.verb import Argument, Verb

VERB = Verb(
    f"{__name__}:python",
    "Start Python with rclpy and message packages to import.",
    passes_everything_on=True,
    examples=(
        "teleopctl python my_node.py --ros-args -r chatter:=/talk",
        "teleopctl python -m pytest",
        "teleopctl python -m jupyter lab",
    ),
)


def python(
    words: Annotated[
        list[str] | None,
        Argument(
            metavar="[ARGS]...",
            help="Python's own: a script, -c CODE, -m MODULE, or nothing for the prompt.",
        ),
    ] = None,
) -> int:
    """Start Python with rclpy and message packages to import.

    It is the Python that teleopctl is installed in, and so is all that it starts in turn. What is
    really installed is used instead. No router is started; `teleopctl daemon start` does that.
    """
    from teleopctl.cli.verbs.run import replace_this_process
    from teleopctl.compat import activation

    activation.activate_children()
    return replace_this_process([sys.executable, *(words or ())])
