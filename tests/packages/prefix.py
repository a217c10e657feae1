"""Install prefixes of ROS packages, as colcon and ROS 2 in /opt/ros create them."""

from collections.abc import Mapping
from pathlib import Path
from textwrap import dedent

INDEX = "share/ament_index/resource_index"

_WRAPPER = """\
#!/usr/bin/python3
# EASY-INSTALL-ENTRY-SCRIPT: '{distribution}==0.0.0','console_scripts','{program}'
import re
import sys

from importlib.metadata import distribution

if __name__ == '__main__':
    sys.argv[0] = re.sub(r'(-script.pyw?|.exe)?$', '', sys.argv[0])
    entries = distribution('{distribution}').entry_points
    entry = next(each for each in entries if each.name == '{program}')
    sys.exit(entry.load()())
"""


def write(file: Path, text: str, mode: int = 0o644) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(dedent(text))
    file.chmod(mode)
    return file


def install(prefix: Path, name: str, files: Mapping[str, str] | None = None) -> Path:
    """Install a package: ament index markers, package.xml, and files by path below the prefix.

    Files below ``lib/NAME`` are executable.
    """
    write(prefix / INDEX / "packages" / name, "")
    write(prefix / INDEX / "package_run_dependencies" / name, "rclpy;std_msgs")
    write(
        prefix / "share" / name / "package.xml",
        f"""\
        <?xml version="1.0"?>
        <package format="3"><name>{name}</name><version>1.2.3</version>
        <exec_depend>rclpy</exec_depend><exec_depend>std_msgs</exec_depend></package>
        """,
    )
    for path, text in (files or {}).items():
        write(prefix / path, text, 0o755 if path.startswith(f"lib/{name}/") else 0o644)
    return prefix


def install_python(prefix: Path, name: str, modules: Mapping[str, str]) -> Path:
    """Install an ament_python package with one executable for each of its modules."""
    site = prefix / "lib/python3.12/site-packages"
    distribution = name.replace("_", "-")
    scripts = "".join(f"{module} = {name}.{module}:main\n" for module in modules)
    metadata = f"lib/python3.12/site-packages/{name}-0.0.0-py3.12.egg-info"
    install(
        prefix,
        name,
        {
            f"{metadata}/PKG-INFO": f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 0\n",
            f"{metadata}/entry_points.txt": f"[console_scripts]\n{scripts}",
        },
    )
    write(site / name / "__init__.py", "")
    for module, text in modules.items():
        write(site / name / f"{module}.py", text)
        wrapper = _WRAPPER.format(distribution=distribution, program=module)
        write(prefix / "lib" / name / module, wrapper, 0o755)
    return prefix


def install_messages(prefix: Path, name: str, messages: Mapping[str, str]) -> Path:
    """Install an interface package whose Python modules import a library that is not installed."""
    install(prefix, name, {f"share/{name}/msg/{each}.msg": text for each, text in messages.items()})
    module = prefix / "lib/python3.12/site-packages" / name
    write(module / "__init__.py", "")
    write(module / "msg/__init__.py", "import rosidl_generator_of_another_machine\n")
    return prefix
