"""``ament_index_python``: its functions and errors, on prefixes as colcon leaves them."""

import os
import sys

import pytest

from tests.compat.activated import output
from tests.packages.prefix import INDEX, install, write

HEAD = "from ament_index_python import *\nfrom ament_index_python.packages import *\n"


posix = pytest.mark.skipif(sys.platform == "win32", reason="paths of POSIX")


@pytest.fixture
def prefixes(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    install(first, "arm", {f"{INDEX}/parser/urdf": "urdf", f"{INDEX}/parser/.hidden": ""})
    install(second, "arm")
    install(second, "hand")
    (second / INDEX / "parser/folder").mkdir(parents=True)
    write(second / INDEX / "parser/urdf", "another")
    write(tmp_path / "ws/leg/package.xml", "<package><name>leg</name></package>")
    return first, second


def said(code: str, prefixes, **environment: str) -> str:
    named = os.pathsep.join(map(str, prefixes))
    variables = {"AMENT_PREFIX_PATH": named, **environment}
    return output(HEAD + code, TELEOPCTL_PACKAGE_PATH=str(prefixes[0].parent / "ws"), **variables)


@posix
def test_packages_are_the_installed_ones_and_those_that_are_used_where_they_lie(prefixes):
    first, second = prefixes
    code = """
found = get_packages_with_prefixes()
print(found["arm"], found["hand"], get_package_share_directory("hand"))
prefix = get_package_share_path("leg"), get_package_prefix("leg")
print(has_resource("packages", "leg") == found["leg"] == prefix[1])
print(prefix[0].name, (prefix[0].__class__(prefix[1]) / "share/leg/package.xml").is_file())
"""
    assert said(code, prefixes).splitlines() == [
        f"{first} {second} {second}/share/hand",
        "True",
        "leg True",
    ]


@posix
def test_resources_of_other_types_are_those_of_the_prefixes(prefixes):
    first, second = prefixes
    code = """
print(get_search_paths(), sorted(get_resource_types()))
print(get_resource("parser", "urdf"), get_resources("parser"))
print(has_resource("parser", "urdf"), has_resource("parser", "sdf"))
"""
    types = ["package_run_dependencies", "packages", "parser"]
    assert said(code, (*prefixes, first / "nowhere")).splitlines() == [
        f"{[str(first), str(second)]} {types}",
        f"{('urdf', str(first))} { ({'urdf': str(first)}) }",
        f"{first} False",
    ]


@pytest.mark.parametrize(
    ("call", "error", "text"),
    [
        ("get_package_prefix('leek')", "PackageNotFoundError", "package 'leek' not found, searchi"),
        ("get_package_share_path('leek')", "PackageNotFoundError", "package 'leek' not found"),
        ("get_package_prefix('_/x')", "ValueError", "'_/x' is not a valid package name"),
        ("get_package_share_directory('a b')", "ValueError", "'a b' is not a valid package name"),
        ("get_resource('parser', 'sdf')", "LookupError", "Could not find the resource 'sdf' of ty"),
        ("get_resource('parser', 'a/b')", "InvalidResourceNameError", "Resource name 'a/b' is inv"),
        ("get_resources('a/b')", "InvalidResourceTypeNameError", "Resource type 'a/b' is invalid"),
        ("has_resource('', 'a')", "AssertionError", "must not be empty"),
    ],
)
def test_errors_are_those_of_the_original(prefixes, call, error, text):
    told = said(f"try:\n    {call}\nexcept Exception as e:\n    print(repr(e))", prefixes)
    assert told.startswith(error)
    assert text in told


def test_without_the_variable_the_prefixes_are_unknown_and_packages_are_not(prefixes):
    code = """
try:
    get_search_paths()
except EnvironmentError as error:
    print(error)
print(get_package_share_path("leg").name)
"""
    assert said(code, prefixes, AMENT_PREFIX_PATH="").splitlines() == [
        "Environment variable 'AMENT_PREFIX_PATH' is not set or empty",
        "leg",
    ]
