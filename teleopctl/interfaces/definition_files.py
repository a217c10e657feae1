"""Definition files of the types that come with teleopctl, laid out as an installation has them."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from teleopctl.interfaces.catalog import Catalog
from teleopctl.interfaces.typenames import split


def write_definitions(share: Path) -> dict[str, list[str]]:
    """Write ``PACKAGE/msg/Name.msg`` and so on for all types that come with teleopctl.

    A folder all of whose files come with teleopctl is a link, if the system allows links.

    Args:
        share: Folder in which the folders of the packages are created.

    Returns:
        Paths of the files below the folder of a package, sorted, by package name.

    Raises:
        OSError: A file cannot be written.
        UsageError: ``ROS_DISTRO`` is a distribution whose types are not known.
    """
    catalog = Catalog()
    written: dict[str, list[str]] = {}
    for (package, kind), group in groupby(catalog.built_in_names(), lambda n: split(n)[:2]):
        names = list(group)
        files = {f"{split(name)[2]}.{kind}": name for name in names}
        written.setdefault(package, []).extend(f"{kind}/{file}" for file in files)
        folder = share / package / kind
        folder.parent.mkdir(parents=True, exist_ok=True)
        source = catalog.folder_of_files(names)
        if source is not None:
            try:
                folder.symlink_to(source, target_is_directory=True)
                continue
            except OSError:  # Windows without the right to create links
                pass
        folder.mkdir()
        for file, name in files.items():
            definition = catalog.find(name)
            assert definition is not None
            (folder / file).write_text(definition.render(), encoding="utf-8", newline="\n")
    return {package: sorted(files) for package, files in sorted(written.items())}
