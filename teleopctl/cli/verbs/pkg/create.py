"""``teleopctl pkg create``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import UsageError
from teleopctl.packages import (
    BUILD_TYPES,
    NewPackage,
    check_package,
    create_package,
    license_names,
)


def create(
    package_name: Annotated[
        str | None, Argument(help="The package's name.", metavar="PACKAGE_NAME")
    ] = None,
    package_format: Annotated[
        str,
        Option(
            "--package-format",
            "--package_format",
            help="The format of its package.xml.",
            choices=("2", "3"),
        ),
    ] = "3",
    description: Annotated[
        str, Option("--description", help="What the package is for.")
    ] = "TODO: Package description",
    license: Annotated[  # noqa: A002 - the option's name
        str,
        Option(
            "--license",
            help="Its license, any text; for those that --license ? lists, a LICENSE is written.",
            complete="licenses",
        ),
    ] = "TODO: License declaration",
    destination_directory: Annotated[
        str, Option("--destination-directory", help="The folder in which the package's is made.")
    ] = ".",
    build_type: Annotated[
        str, Option("--build-type", help="How it is built.", choices=BUILD_TYPES)
    ] = "ament_cmake",
    dependencies: Annotated[
        list[str] | None,
        Option("--dependencies", help="Packages that it needs.", complete="packages"),
    ] = None,
    maintainer_email: Annotated[
        str | None,
        Option("--maintainer-email", help="The maintainer's address; otherwise the one in git."),
    ] = None,
    maintainer_name: Annotated[
        str | None,
        Option("--maintainer-name", help="The maintainer's name; otherwise the user's."),
    ] = None,
    node_name: Annotated[
        str | None, Option("--node-name", help="A program that it is to have.")
    ] = None,
    library_name: Annotated[
        str | None, Option("--library-name", help="A library that it is to have.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Create a new package.

    In one of the build type ament_python a node runs at once: teleopctl run PACKAGE NODE.
    """
    import os

    if license == "?":
        names = list(license_names())
        text = "\n".join(["Supported licenses:", *names])
        console.out_done(text, as_json=as_json, licenses=names)
        return
    if package_name is None:
        raise UsageError("Missing argument 'PACKAGE_NAME'.")
    name = maintainer_name or _user()
    if node_name and node_name == library_name:
        node_name += "_node"
        console.note(
            "[WARNING] node name can not be equal to the library name\n"
            f"[WARNING] renaming node to {node_name}"
        )
    package = NewPackage(
        package_name,
        build_type,
        int(package_format),
        description,
        license,
        name,
        maintainer_email or _address_in_git() or f"{name}@todo.todo",
        tuple(dependencies or ()),
        node_name,
        library_name,
    )
    check_package(package, destination_directory)
    directory = os.path.abspath(destination_directory)  # noqa: PTH100 - as it was named
    if as_json:
        create_package(package, destination_directory, lambda _: None)
        console.out_json(
            {
                "package": package.name,
                "folder": os.path.join(directory, package.name),  # noqa: PTH118
                "build_type": package.build_type,
                "node": package.node_name,
                "library": package.library_name,
            }
        )
    else:
        console.out_lines(_summary(package, directory))
        create_package(package, destination_directory, console.out)
    if license not in license_names():
        console.flush()
        console.note(
            f"\n[WARNING]: Unknown license '{license}'.  This has been set in the package.xml, but "
            "no LICENSE file has been created.\nIt is recommended to use one of the ament license "
            "identifiers:\n" + "\n".join(license_names())
        )


def _summary(package: NewPackage, directory: str) -> list[str]:
    lines = [
        "going to create a new package",
        f"package name: {package.name}",
        f"destination directory: {directory}",
        f"package format: {package.package_format}",
        "version: 0.0.0",
        f"description: {package.description}",
        f"maintainer: {[f'{package.maintainer_name} <{package.maintainer_email}>']}",
        f"licenses: {[package.license]}",
        f"build type: {package.build_type}",
        f"dependencies: {list(package.dependencies)}",
    ]
    if package.node_name:
        lines.append(f"node_name: {package.node_name}")
    if package.library_name:
        lines.append(f"library_name: {package.library_name}")
    return lines


def _user() -> str:
    import getpass

    try:
        return getpass.getuser()
    except (KeyError, OSError, ImportError):  # a container's user without a name
        return "user"


def _address_in_git() -> str:
    import shutil
    import subprocess

    git = shutil.which("git")
    if git is None:
        return ""
    asked = [git, "config", "user.email"]
    return subprocess.run(asked, capture_output=True, text=True, check=False).stdout.strip()
