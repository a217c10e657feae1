"""The files of a new ``ament_python`` package, besides its manifest."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from teleopctl.packages.new.package import NewPackage
from teleopctl.packages.new.steps import File, Folder, Note, Step, joined

_SETUP_PY: Final = """\
from setuptools import find_packages, setup

package_name = {name!r}

setup(
    name=package_name,
    version='0.0.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages',
            ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer={maintainer_name!r},
    maintainer_email={maintainer_email!r},
    description={description!r},
    license={license!r},
    extras_require={{
        'test': ['pytest'],
    }},
    entry_points={{
        'console_scripts': [{scripts}],
    }},
)
"""

_SETUP_CFG: Final = """\
[develop]
script_dir=$base/lib/{name}
[install]
install_scripts=$base/lib/{name}
"""

_MAIN: Final = """\
def main():
    print('Hi from {name}.')


if __name__ == '__main__':
    main()
"""

_LINTER_TEST: Final = """\
from ament_{linter}.main import {main}
import pytest


{skip}@pytest.mark.{linter}
@pytest.mark.linter
def test_{linter}():
    {check}
"""

_SKIP: Final = "@pytest.mark.skip(reason='The files have no copyright header yet.')\n"
_CHECK: Final = "assert main(argv=['.', 'test']) == 0, 'Found errors'"
_CHECK_FLAKE8: Final = """\
status, errors = main_with_errors(argv=[])
    assert status == 0, 'Found errors:\\n' + '\\n'.join(errors)"""


def python_files(package: NewPackage, folder: str) -> Iterator[Step]:
    """Yield the files of a Python package."""
    source = joined(folder, package.name)
    yield Note("creating source folder")
    yield Folder(source)
    yield File(joined(folder, "setup.py"), _setup_py(package))
    yield File(joined(folder, "setup.cfg"), _SETUP_CFG.format(name=package.name))
    yield Folder(joined(folder, "resource"))
    yield File(joined(folder, "resource", package.name), "")
    yield File(joined(source, "__init__.py"), "")
    yield Folder(joined(folder, "test"))
    for linter, main, skip, check in (
        ("copyright", "main", _SKIP, _CHECK),
        ("flake8", "main_with_errors", "", _CHECK_FLAKE8),
        ("pep257", "main", "", _CHECK),
    ):
        text = _LINTER_TEST.format(linter=linter, main=main, skip=skip, check=check)
        yield File(joined(folder, "test", f"test_{linter}.py"), text)
    if package.node_name:
        text = _MAIN.format(name=package.name)
        yield File(joined(source, f"{package.node_name}.py"), text)
    if package.library_name:
        yield Folder(joined(source, package.library_name))
        yield File(joined(source, package.library_name, "__init__.py"), "")


def _setup_py(package: NewPackage) -> str:
    name = package.node_name
    script = f"{name} = {package.name}.{name}:main"
    scripts = f"\n            '{script}',\n        " if name else "\n        "
    return _SETUP_PY.format(scripts=scripts, **package._asdict())
