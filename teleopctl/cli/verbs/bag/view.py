"""``teleopctl bag view``."""

from pathlib import Path
from typing import TYPE_CHECKING

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.verb import Option
from teleopctl.cli.verbs.bag.options import BagPath
from teleopctl.errors import UsageError

if TYPE_CHECKING:
    from teleopctl.base.token_file import Address


def view(
    bag_path: BagPath,
    display_config: Annotated[
        str | None,
        Option("-d", "--display-config", help="An .rviz file to start with.", metavar="FILE"),
    ] = None,
    over: Annotated[
        str | None,
        Option(
            "--over",
            help="A second bag to show over it, from its start on; its topics and frames begin "
            "with 'over'.",
            metavar="BAG",
            complete="files",
        ),
    ] = None,
    rate: Annotated[float, Option("-r", "--rate", help="Seconds of the bag per second.")] = 1.0,
    start_paused: Annotated[bool, Option("-p", "--start-paused", help="Begin paused.")] = False,
    host: Annotated[str, Option("--host", help="Address to listen on.")] = "127.0.0.1",
    port: Annotated[
        int | None,
        Option("--port", help="Port to listen on; by default 8080, or the next free one."),
    ] = None,
    token_file: Annotated[
        str | None,
        Option(
            "--token-file",
            help="File of the page's access token; created if missing.",
            metavar="FILE",
        ),
    ] = None,
    open_page: Annotated[bool, Option("--open", help="Open the page in the browser.")] = False,
) -> None:
    """Serve a bag to the browser viewer, with a time line to drag, until Ctrl-C."""
    if rate <= 0:
        raise UsageError(f"--rate {rate:g}: a bag is played forwards, so that it is above 0")
    from teleopctl.nodes.bag_view import view_bag

    def tell(address: "Address", domain: int) -> None:
        console.out(f"The bag in your browser: {address.with_token}")
        console.out(f"Its topics: ROS_DOMAIN_ID={domain} teleopctl topic list")
        console.flush()
        if open_page:
            from teleopctl.nodes.rviz2 import open_in_browser

            open_in_browser(address)

    view_bag(
        Path(bag_path),
        host=host,
        port=port,
        token_file=Path(token_file).expanduser() if token_file else None,
        view=Path(display_config) if display_config else None,
        over=Path(over) if over else None,
        rate=rate,
        is_paused=start_paused,
        on_ready=tell,
    )
