"""``teleopctl component types``."""

from teleopctl.base.typed import Annotated
from teleopctl.cli import console
from teleopctl.cli.options import AsJson
from teleopctl.cli.verb import Argument
from teleopctl.errors import NotFoundError, did_you_mean
from teleopctl.packages import list_components, package_names


def list_types(
    package_name: Annotated[
        str | None, Argument(help="The package; otherwise all.", complete="packages")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the components that can be loaded, by package."""
    types = {
        package: [component.type_name for component in components]
        for package, components in list_components().items()
    }
    if package_name is None:
        if as_json:
            console.out_json(types)
            return
        for package, names in types.items():
            console.out(package)
            console.out_lines(f"  {name}" for name in names)
        return
    if package_name not in types and package_name not in package_names():
        raise NotFoundError(
            f"Unable to find package '{package_name}'",
            hint=did_you_mean(package_name, types),
        )
    names = types.get(package_name, [])
    if as_json:
        console.out_json(names)
    else:
        console.out_lines(names)
