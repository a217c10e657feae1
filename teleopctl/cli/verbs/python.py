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
    """Replace this process by the Python interpreter, with rclpy and messages importable.

    Runs the Python interpreter of teleopctl; programs that it starts can import the packages as
    well. Installed packages take precedence. Starts no router; use `teleopctl daemon start`.
    """
    from teleopctl.cli.verbs.run import replace_this_process
    from teleopctl.compat import activation

    activation.activate_children()
    return replace_this_process([sys.executable, *(words or ())])
