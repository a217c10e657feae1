"""``teleopctl pkg list|executables|prefix|xml``."""

from teleopctl import packages
from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument, Option
from teleopctl.errors import BrokenPluginError, InvalidFileError, NotFoundError, did_you_mean
from teleopctl.packages import Package

_PackageName = Annotated[
    str, Argument(metavar="PACKAGE", help="Name of the package.", complete="packages")
]


def list_packages(
    as_json: AsJson = False,
    verbose: Annotated[
        bool,
        Option("-v", "--verbose", help="Tell where each was found, and what it hides."),
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


def _place(package: Package) -> dict[str, str]:
    return {
        "name": package.name,
        "folder": str(package.folder),
        "source": package.found_by,
    }


def _others(package: Package) -> list[tuple[str, list[Package]]]:
    """The other packages of a name: which give it programs first, and which it hides."""
    try:
        layers = packages.package_layers(package.name)
    except BrokenPluginError:  # told where it is used
        return []
    at = next((at for at, one in enumerate(layers) if one.folder == package.folder), 0)
    return [("programs", layers[:at]), ("hides", layers[at + 1 :])]


def executables(
    name: Annotated[
        str | None,
        Argument(metavar="[PACKAGE]", help="Name of the package.", complete="packages"),
    ] = None,
    full_path: Annotated[
        bool, Option("--full-path", help="Print the path of a file that runs each.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """List the programs of packages.

    A program that is not installed is run by a file that is written for --full-path.
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


def _path(package: Package, program: str) -> object:
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
    """Print the folder below which a package is installed.

    Of one that is used where it lies, that is a folder of links. Where several packages have that
    name, those that it hides are named on stderr.
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


def _found(name: str) -> Package:
    """The package of a name.

    Raises:
        NotFoundError: There is none.
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

    manifest = _found(name).share / "package.xml"
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
