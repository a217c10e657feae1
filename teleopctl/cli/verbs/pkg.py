"""``teleopctl pkg``: packages, their places and programs, and new ones."""

from teleopctl import packages
from teleopctl.base.typed import TYPE_CHECKING, Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option, Verb, VerbGroup
from teleopctl.errors import (
    BrokenPluginError,
    InvalidFileError,
    NotFoundError,
    UsageError,
    did_you_mean,
)
from teleopctl.packages import BUILD_TYPES

if TYPE_CHECKING:
    from teleopctl.cli.completion.completing import TypedWords
    from teleopctl.packages import NewPackage, Package


GROUP = VerbGroup(
    "Find and create packages.",
    {
        "create": Verb(
            f"{__name__}:create",
            "Create a new package.",
            examples=(
                "teleopctl pkg create --build-type ament_python --node-name talker greeter",
                "teleopctl pkg create greeter --dependencies rclpy std_msgs",
            ),
        ),
        "executables": Verb(f"{__name__}:executables", "List the programs of packages."),
        "list": Verb(f"{__name__}:list_packages", "List the packages."),
        "prefix": Verb(
            f"{__name__}:prefix", "Print the folder below which a package is installed."
        ),
        "xml": Verb(f"{__name__}:xml", "Print the manifest of a package, or a tag of it."),
    },
)


_PackageName = Annotated[
    str, Argument(metavar="PACKAGE", help="Name of the package.", complete="packages")
]


def list_packages(
    as_json: AsJson = False,
    verbose: Annotated[
        bool,
        Option(
            "-v", "--verbose", help="Print the folder of each package, and which packages it hides."
        ),
    ] = False,
) -> None:
    """List the packages."""
    if not (verbose or as_json):
        console.out_lines(packages.package_names())
        return
    listed = [(package, _others(package)) for package in packages.list_packages()]
    if as_json:
        console.out_json(
            [
                {**_place(package), **{role: list(map(_place, ones)) for role, ones in others}}
                for package, others in listed
            ]
        )
        return
    for package, others in listed:
        console.out(f"{package.name}  {package.folder}  [{package.found_by}]")
        for role, ones in others:
            console.out_lines(f"  {role}  {one.folder}  [{one.found_by}]" for one in ones)
    console.flush()
    for fault in packages.faults_of_search():
        console.note(fault)


def _place(package: "Package") -> dict[str, str]:
    return {
        "name": package.name,
        "folder": str(package.folder),
        "source": package.found_by,
    }


def _others(package: "Package") -> "list[tuple[str, list[Package]]]":
    """Return other packages of the same name: those whose programs come first, and hidden ones."""
    try:
        layers = packages.package_layers(package.name)
    except BrokenPluginError:  # reported when the package is used
        return []
    at = next((at for at, one in enumerate(layers) if one.folder == package.folder), 0)
    return [("programs", layers[:at]), ("hides", layers[at + 1 :])]


def executables(
    name: Annotated[
        str | None,
        Argument(metavar="[PACKAGE]", help="Name of the package.", complete="packages"),
    ] = None,
    full_path: Annotated[
        bool, Option("--full-path", help="Print the full path of each program.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the programs of one package or of all packages.

    With --full-path, a script is written for programs that are not installed.
    """
    found = packages.list_packages() if name is None else [packages.find_package(name)]
    programs = [(package, program) for package in found for program in sorted(package.executables)]
    if as_json:
        console.out_json(
            [{"package": package.name, "executable": program} for package, program in programs]
        )
    elif full_path:
        console.out_lines(str(_path(package, program)) for package, program in programs)
    else:
        console.out_lines(f"{package.name} {program}" for package, program in programs)


def _path(package: "Package", program: str) -> object:
    file = package.executables[program].file
    installed = package.prefix / "lib" / package.name / program
    return installed if file is None or installed.is_file() else file


def prefix(
    name: _PackageName,
    share: Annotated[
        bool, Option("--share", help="Print the folder of the package's files instead.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Print the install prefix of a package, or with ``share`` the package's share folder.

    For a package that is used from its source folder, this is a folder of links. If several
    packages have the name, the hidden ones are printed to stderr.
    """
    package = _found(name)
    if as_json:
        folders = {"prefix": str(package.prefix), "share": str(package.share)}
        console.out_json({"package": name, **folders})
    else:
        console.out(str(package.share if share else package.prefix))
    console.flush()
    for hidden in dict(_others(package)).get("hides", ()):
        programs = ", ".join(sorted(hidden.executables)) or "none"
        console.note(f"It hides {hidden.folder} (programs: {programs})")


def _found(name: str) -> "Package":
    """Return the package of a name.

    Raises:
        NotFoundError: No package has this name.
    """
    try:
        return packages.find_package(name)
    except NotFoundError as error:
        raise NotFoundError(f"Package not found: '{name}'", hint=error.hint) from error


def xml(
    name: _PackageName,
    tag: Annotated[
        str | None,
        Option(
            "-t",
            "--tag",
            help="Print the text of the elements of this name, such as version.",
            complete="manifest_tags",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print the manifest of a package, or the text of one of its tags."""
    from lxml import etree

    manifest = _found(name).manifest
    if not manifest.is_file():
        raise NotFoundError(
            f"Package XML manifest not found: package '{name}' has no {manifest.name}"
        )
    parser = etree.XMLParser(resolve_entities=False, remove_comments=True, remove_pis=True)
    try:
        root = etree.parse(manifest, parser).getroot()
    except (OSError, etree.XMLSyntaxError) as error:
        raise InvalidFileError(f"{manifest}: {error}") from error
    if tag is None:
        text = etree.tostring(root, encoding="unicode")
        console.out_done(text, as_json=as_json, package=name, file=str(manifest), xml=text)
        return
    found = root.findall(tag)
    if not found:
        raise NotFoundError(
            f"XML tag not found: {manifest} has no <{tag}>",
            hint=did_you_mean(tag, {str(element.tag) for element in root}),
        )
    texts = [element.text or "" for element in found]
    console.out_done("\n".join(texts), as_json=as_json, package=name, tag=tag, texts=texts)


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
        str, Option("--destination-directory", help="Folder in which the package is created.")
    ] = ".",
    build_type: Annotated[
        str | None,
        Option(
            "--build-type",
            help="Build type; by default ament_python with --controller, else ament_cmake.",
            choices=BUILD_TYPES,
        ),
    ] = None,
    dependencies: Annotated[
        list[str] | None,
        Option("--dependencies", help="Packages that it depends on.", complete="packages"),
    ] = None,
    maintainer_email: Annotated[
        str | None,
        Option("--maintainer-email", help="Maintainer's address; by default that of git."),
    ] = None,
    maintainer_name: Annotated[
        str | None,
        Option("--maintainer-name", help="Maintainer's name; by default the user's."),
    ] = None,
    node_name: Annotated[
        str | None, Option("--node-name", help="Name of a program to create.")
    ] = None,
    library_name: Annotated[
        str | None, Option("--library-name", help="Name of a library to create.")
    ] = None,
    controller: Annotated[
        str | None,
        Option(
            "--controller",
            help="Name of a controller to create, with parameters and a test.",
            metavar="NAME",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Create a new package.

    Nodes of an ament_python package can be run at once: teleopctl run PACKAGE NODE.
    """
    import os

    from teleopctl.packages import NewPackage, check_package, create_package, license_names

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
        build_type or ("ament_python" if controller else "ament_cmake"),
        int(package_format),
        description,
        license,
        name,
        maintainer_email or _address_in_git() or f"{name}@todo.todo",
        tuple(dependencies or ()),
        node_name,
        library_name,
        controller,
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
                "controller": package.controller,
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


def _summary(package: "NewPackage", directory: str) -> list[str]:
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
    if package.controller:
        lines.append(f"controller: {package.controller}")
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


def complete_manifest_tags(ctx: "TypedWords", incomplete: str) -> list[str]:
    """Return completion candidates: the tags in the manifest of the package on the command line."""
    from lxml import etree

    from teleopctl import packages

    parser = etree.XMLParser(resolve_entities=False, remove_comments=True, remove_pis=True)

    try:
        package = packages.lookup_package(ctx.params.get("name") or "")
        if package is None:
            return []
        root = etree.parse(package.manifest, parser).getroot()
    except (OSError, etree.XMLSyntaxError):
        return []
    return sorted(
        {tag for tag in map(str, (each.tag for each in root)) if tag.startswith(incomplete)}
    )


def complete_licenses(incomplete: str) -> list[str]:
    """Return completion candidates: the licenses with known text."""
    from teleopctl.packages import license_names

    return [name for name in license_names() if name.startswith(incomplete)]
