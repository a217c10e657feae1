"""``teleopctl bag convert``."""

from pathlib import Path

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.cli.verbs.bag.options import CompressionName, MaxBagDuration, MaxBagSize

_STORAGES = ("mcap", "sqlite3")


def convert_bag(
    output: Annotated[
        str,
        Option(
            "-o",
            "--output-options",
            help="The folder to be made, or a YAML file with the outputs, as ros2 bag has it.",
            metavar="FOLDER_OR_YAML",
        ),
    ],
    words: Annotated[
        list[str] | None,
        Argument(help="The bags, merged by time.", metavar="BAG...", complete="bags"),
    ] = None,
    inputs: Annotated[
        list[str] | None,
        Option(
            "-i",
            "--input",
            help="A bag, and its storage (mcap or sqlite3) if that is not evident; repeatable.",
            metavar="BAG",
            complete="bags",
        ),
    ] = None,
    input_options: Annotated[
        str | None,
        Option(
            "--input-options",
            help="A YAML file with the bags, and from when to when each is read.",
            metavar="YAML",
        ),
    ] = None,
    storage: Annotated[
        str, Option("-s", "--storage", help="Form of what is written.", choices=_STORAGES)
    ] = "mcap",
    compression: CompressionName = "zstd",
    max_bag_size: MaxBagSize = 0,
    max_bag_duration: MaxBagDuration = 0.0,
    as_json: AsJson = False,
) -> None:
    """Write bags in another form, such as SQLite databases, packed ones and ROS 1's bags as MCAP.

    With a YAML file there may be several outputs, each with its own choice of topics; it says form,
    compression and sizes itself.
    """
    from teleopctl.bag import BagPart, OutputBag, read_outputs
    from teleopctl.cli.verbs.bag.files import writing

    sources = writing.inputs(inputs or [], words or [], input_options)
    target = Path(output)
    options = writing.writer_options(compression, max_bag_size, max_bag_duration, storage)
    outputs = [OutputBag(target, options=options)]
    if target.suffix in (".yaml", ".yml") or target.is_file():
        outputs, remarks = read_outputs(target)
        for remark in remarks:
            console.warn(remark)
    with writing.opened(
        [str(source.path) for source in sources], [source.storage for source in sources]
    ) as bags:
        parts = [
            BagPart(bag, source.start_ns, source.end_ns)
            for bag, source in zip(bags, sources, strict=True)
        ]
        writing.write(parts, outputs, as_json=as_json)
