"""The ``package.xml`` of a new package."""

from __future__ import annotations

from typing import Final

from teleopctl.packages.new.package import AMENT_CMAKE, AMENT_PYTHON, NewPackage

_TEST_DEPENDENCIES: Final = {
    AMENT_CMAKE: ("ament_lint_auto", "ament_lint_common"),
    AMENT_PYTHON: ("ament_copyright", "ament_flake8", "ament_pep257", "python3-pytest"),
}


def package_xml(package: NewPackage) -> str:
    """Return the text of ``package.xml``."""
    from xml.sax.saxutils import escape, quoteattr

    schema = f"http://download.ros.org/schema/package_format{package.package_format}.xsd"
    lines = [
        '<?xml version="1.0"?>',
        f'<?xml-model href="{schema}" schematypens="http://www.w3.org/2001/XMLSchema"?>',
        f'<package format="{package.package_format}">',
        f"  <name>{package.name}</name>",
        "  <version>0.0.0</version>",
        f"  <description>{escape(package.description)}</description>",
        f"  <maintainer email={quoteattr(package.maintainer_email)}>"
        f"{escape(package.maintainer_name)}</maintainer>",
        f"  <license>{escape(package.license)}</license>",
        "",
    ]
    tools: tuple[str, ...] = ()
    if package.build_type == AMENT_CMAKE:
        tools = ("ament_cmake_ros" if package.library_name else "ament_cmake",)
    for tag, names in (
        ("buildtool_depend", tools),
        ("depend", package.dependencies),
        ("test_depend", _TEST_DEPENDENCIES.get(package.build_type, ())),
    ):
        lines += [f"  <{tag}>{name}</{tag}>" for name in names]
        lines += [""] if names else []
    build_type = f"    <build_type>{package.build_type}</build_type>"
    return "\n".join([*lines, "  <export>", build_type, "  </export>", "</package>", ""])
