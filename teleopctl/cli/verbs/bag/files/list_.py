"""``teleopctl bag list``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option

# What is there, with what ``-v`` says of it.
_PLUGINS = {
    "storage": {
        "mcap": "MCAP files, read and written.",
        "sqlite3": "SQLite databases, those of older ROS 2 distributions too, read and written.",
        "rosbag_v2": "Bags of ROS 1, read.",
    },
    "converter": {"cdr": "The form of messages on the wire, which is written as it came."},
    "compressor": {
        "zstd": "Chunks of MCAP files, small.",
        "lz4": "Chunks of MCAP files, fast.",
    },
    "decompressor": {
        "zstd": "Chunks of MCAP files; files and messages of rosbag2's own compression.",
        "lz4": "Chunks of MCAP files.",
    },
}


def list_plugins(
    plugin_type: Annotated[
        str, Argument(help="Which ones.", metavar="KIND", choices=tuple(_PLUGINS))
    ],
    verbose: Annotated[bool, Option("-v", "--verbose", help="Say what each one is for.")] = False,
    as_json: AsJson = False,
) -> None:
    """List the forms of files, messages and compression that bags may have."""
    if as_json:
        console.out_json(
            [{"name": name, "description": text} for name, text in _PLUGINS[plugin_type].items()]
        )
        return
    if verbose:
        console.out(f"available {plugin_type} plugins are:")
    for name, description in _PLUGINS[plugin_type].items():
        console.out(f"name: {name}" if verbose else name)
        if verbose:
            console.out_text(f"\t{description}")
