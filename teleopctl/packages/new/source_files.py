"""Source and build files of a new package: Python, C++ with CMake, and Rust with Cargo."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from teleopctl.packages.new.controller_files import (
    controller_entry_point,
    controller_files,
    controller_names,
)
from teleopctl.packages.new.package import (
    AMENT_CMAKE,
    File,
    Folder,
    NewPackage,
    Note,
    Step,
    join_path,
)

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
{data}    ],
    install_requires=[{requires}],
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
{points}    }},
)
"""

_SETUP_CFG: Final = """\
[develop]
script_dir=$base/lib/{name}
[install]
install_scripts=$base/lib/{name}
"""

_PYTHON_MAIN: Final = """\
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
    """Yield the steps that create the folders and files of a Python package."""
    source = join_path(folder, package.name)
    yield Note("creating source folder")
    yield Folder(source)
    yield File(join_path(folder, "setup.py"), _setup_py(package))
    yield File(join_path(folder, "setup.cfg"), _SETUP_CFG.format(name=package.name))
    yield Folder(join_path(folder, "resource"))
    yield File(join_path(folder, "resource", package.name), "")
    yield File(join_path(source, "__init__.py"), "")
    yield Folder(join_path(folder, "test"))
    if package.controller:
        yield from controller_files(package, folder)
    for linter, main, skip, check in (
        ()
        if package.controller
        else (
            ("copyright", "main", _SKIP, _CHECK),
            ("flake8", "main_with_errors", "", _CHECK_FLAKE8),
            ("pep257", "main", "", _CHECK),
        )
    ):
        text = _LINTER_TEST.format(linter=linter, main=main, skip=skip, check=check)
        yield File(join_path(folder, "test", f"test_{linter}.py"), text)
    if package.node_name:
        text = _PYTHON_MAIN.format(name=package.name)
        yield File(join_path(source, f"{package.node_name}.py"), text)
    if package.library_name:
        yield Folder(join_path(source, package.library_name))
        yield File(join_path(source, package.library_name, "__init__.py"), "")


def _setup_py(package: NewPackage) -> str:
    name = package.node_name
    script = f"{name} = {package.name}.{name}:main"
    scripts = f"\n            '{script}',\n        " if name else "\n        "
    data = points = ""
    requires = "'setuptools'"
    if package.controller:
        file = f"config/{controller_names(package.controller)[0]}.yaml"
        data = f"        ('share/' + package_name + '/config', ['{file}']),\n"
        points = (
            "        'teleopctl.controllers': [\n"
            f"            '{controller_entry_point(package)}',\n        ],\n"
        )
        requires += ", 'teleopctl'"
    return _SETUP_PY.format(
        scripts=scripts, data=data, points=points, requires=requires, **package._asdict()
    )


_CPP_MAIN: Final = """\
#include <cstdio>

int main(int, char **)
{{
  std::printf("hello world {name} package\\n");
  return 0;
}}
"""

_HEADER: Final = """\
#ifndef {guard}__{library_guard}_HPP_
#define {guard}__{library_guard}_HPP_

#include "{name}/visibility_control.h"

namespace {namespace}
{{

class {guard}_PUBLIC {class_name}
{{
public:
  {class_name}();

  virtual ~{class_name}();
}};

}}  // namespace {namespace}

#endif  // {guard}__{library_guard}_HPP_
"""

_SOURCE: Final = """\
#include "{name}/{library}.hpp"

namespace {namespace}
{{

{class_name}::{class_name}() = default;

{class_name}::~{class_name}() = default;

}}  // namespace {namespace}
"""

_VISIBILITY: Final = """\
#ifndef {guard}__VISIBILITY_CONTROL_H_
#define {guard}__VISIBILITY_CONTROL_H_

// {guard}_PUBLIC marks what a shared library shows; {guard}_BUILDING_LIBRARY is defined where the
// library itself is compiled, rather than a program that uses it.

#if defined _WIN32 || defined __CYGWIN__
  #ifdef __GNUC__
    #define {guard}_EXPORT __attribute__ ((dllexport))
    #define {guard}_IMPORT __attribute__ ((dllimport))
  #else
    #define {guard}_EXPORT __declspec(dllexport)
    #define {guard}_IMPORT __declspec(dllimport)
  #endif
  #ifdef {guard}_BUILDING_LIBRARY
    #define {guard}_PUBLIC {guard}_EXPORT
  #else
    #define {guard}_PUBLIC {guard}_IMPORT
  #endif
  #define {guard}_PUBLIC_TYPE {guard}_PUBLIC
  #define {guard}_LOCAL
#else
  #define {guard}_EXPORT __attribute__ ((visibility("default")))
  #define {guard}_IMPORT
  #define {guard}_PUBLIC __attribute__ ((visibility("default")))
  #define {guard}_LOCAL __attribute__ ((visibility("hidden")))
  #define {guard}_PUBLIC_TYPE
#endif

#endif  // {guard}__VISIBILITY_CONTROL_H_
"""


def cpp_files(package: NewPackage, source: str, include: str) -> Iterator[Step]:
    """Yield the steps that create the source and header files of a C++ package."""
    library = package.library_name or ""
    names = {
        "name": package.name,
        "guard": _identifier(package.name).upper(),
        "namespace": _identifier(package.name),
        "library": library,
        "library_guard": _identifier(library).upper(),
        "class_name": _identifier(library).replace("_", " ").title().replace(" ", ""),
    }
    if package.node_name:
        yield File(join_path(source, f"{package.node_name}.cpp"), _CPP_MAIN.format(**names))
    if library:
        yield File(join_path(include, f"{library}.hpp"), _HEADER.format(**names))
        yield File(join_path(source, f"{library}.cpp"), _SOURCE.format(**names))
        yield File(join_path(include, "visibility_control.h"), _VISIBILITY.format(**names))


def _identifier(name: str) -> str:
    return name.replace("-", "_").replace(".", "_")


_WARNINGS: Final = """\
if(CMAKE_COMPILER_IS_GNUCXX OR CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  add_compile_options(-Wall -Wextra -Wpedantic)
endif()
"""

_NO_DEPENDENCIES: Final = """\
# packages that this one needs:
# find_package(<package> REQUIRED)
"""

_AMENT_TESTS: Final = """\
if(BUILD_TESTING)
  find_package(ament_lint_auto REQUIRED)
  # Delete this line once every source file has a copyright header.
  set(ament_cmake_copyright_FOUND TRUE)
  # Delete this line once the package has a copyright header in every file and is kept in git.
  set(ament_cmake_cpplint_FOUND TRUE)
  ament_lint_auto_find_test_dependencies()
endif()
"""

_VERSION: Final = """\
set({name}_MAJOR_VERSION 0)
set({name}_MINOR_VERSION 0)
set({name}_PATCH_VERSION 0)
set({name}_VERSION
  ${{{name}_MAJOR_VERSION}}.${{{name}_MINOR_VERSION}}.${{{name}_PATCH_VERSION}})
"""

_EXPORT: Final = """\
# let other packages find this one
export(EXPORT export_${{PROJECT_NAME}}
  FILE "${{PROJECT_BINARY_DIR}}/export_${{PROJECT_NAME}}.cmake")

set(CONF_INCLUDE_DIRS "${{CMAKE_INSTALL_PREFIX}}/include")
configure_file({name}Config.cmake.in
  "${{PROJECT_BINARY_DIR}}/${{CMAKE_FILES_DIRECTORY}}/{name}Config.cmake" @ONLY)
configure_file({name}ConfigVersion.cmake.in
  "${{PROJECT_BINARY_DIR}}/{name}ConfigVersion.cmake" @ONLY)

install(FILES
  "${{PROJECT_BINARY_DIR}}/${{CMAKE_FILES_DIRECTORY}}/{name}Config.cmake"
  "${{PROJECT_BINARY_DIR}}/{name}ConfigVersion.cmake"
  DESTINATION "share/${{PROJECT_NAME}}/cmake" COMPONENT dev)
install(EXPORT export_${{PROJECT_NAME}}
  DESTINATION "share/${{PROJECT_NAME}}/cmake"
  FILE export_${{PROJECT_NAME}}.cmake
  COMPONENT dev)
"""

_CONFIG: Final = """\
# What find_package({name}) gives:
#  {name}_INCLUDE_DIRS: where its headers are
#  {name}_LIBRARIES: what to link
#  {name}_EXECUTABLE: its program

set({name}_INCLUDE_DIRS "@CONF_INCLUDE_DIRS@")
include("${{{name}_DIR}}/export_{name}.cmake")
"""

_CONFIG_VERSION: Final = """\
set(PACKAGE_VERSION "@{name}_VERSION@")

if("${{PACKAGE_VERSION}}" VERSION_LESS "${{PACKAGE_FIND_VERSION}}")
  set(PACKAGE_VERSION_COMPATIBLE FALSE)
else()
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
  if("${{PACKAGE_VERSION}}" VERSION_EQUAL "${{PACKAGE_FIND_VERSION}}")
    set(PACKAGE_VERSION_EXACT TRUE)
  endif()
endif()
"""


def cmake_files(package: NewPackage, folder: str) -> Iterator[Step]:
    """Yield the steps that create the build files of a CMake package."""
    yield File(join_path(folder, "CMakeLists.txt"), _cmake_lists(package))
    if package.build_type == AMENT_CMAKE:
        return
    name = package.name
    config = _CONFIG.format(name=name)
    if package.library_name:
        config += f"set({name}_LIBRARIES {package.library_name})\n"
    if package.node_name:
        config += f"set({name}_EXECUTABLE {package.node_name})\n"
    yield File(join_path(folder, f"{name}Config.cmake.in"), config)
    version = _CONFIG_VERSION.format(name=name)
    yield File(join_path(folder, f"{name}ConfigVersion.cmake.in"), version)


def _cmake_lists(package: NewPackage) -> str:
    is_ament = package.build_type == AMENT_CMAKE
    has_targets = bool(package.library_name or package.node_name)
    tools = ["ament_cmake"] if is_ament else []
    if is_ament and package.library_name:
        tools.append("ament_cmake_ros")
    found = [f"find_package({name} REQUIRED)\n" for name in (*tools, *package.dependencies)]
    if not package.dependencies:
        found.append(_NO_DEPENDENCIES)
    parts = [
        f"cmake_minimum_required(VERSION 3.8)\nproject({package.name})\n",
        "" if is_ament else _VERSION.format(name=package.name),
        _WARNINGS,
        "# find dependencies\n" + "".join(found),
        _library(package) if package.library_name else "",
        _program(package) if package.node_name else "",
        _AMENT_TESTS if is_ament else "",
        _ament_export(package) if is_ament and package.library_name else "",
        "ament_package()\n" if is_ament else "",
        _EXPORT.format(name=package.name) if has_targets and not is_ament else "",
    ]
    return "\n".join(part for part in parts if part)


def _library(package: NewPackage) -> str:
    library = package.library_name or ""
    kind = "" if package.build_type == AMENT_CMAKE else "SHARED "
    guard = package.name.replace("-", "_").upper()
    includes = _installed_includes(package)
    return f"""\
add_library({library} {kind}src/{library}.cpp)
add_library({package.name}::{library} ALIAS {library})
{_target(package, library, "PUBLIC")}
# the visibility macros: dllexport in the library itself, dllimport in what uses it
target_compile_definitions({library} PRIVATE "{guard}_BUILDING_LIBRARY")

install(
  DIRECTORY include/
  DESTINATION {includes}
)
install(
  TARGETS {library}
  EXPORT export_${{PROJECT_NAME}}
  ARCHIVE DESTINATION lib
  LIBRARY DESTINATION lib
  RUNTIME DESTINATION bin
)
"""


def _program(package: NewPackage) -> str:
    node = package.node_name or ""
    linked = f"target_link_libraries({node} PUBLIC {package.library_name})\n"
    export = "" if package.build_type == AMENT_CMAKE else "\n  EXPORT export_${PROJECT_NAME}"
    return f"""\
add_executable({node} src/{node}.cpp)
{_target(package, node, "PUBLIC")}{linked if package.library_name else ""}
install(TARGETS {node}{export}
  DESTINATION lib/${{PROJECT_NAME}})
"""


def _target(package: NewPackage, target: str, scope: str) -> str:
    """Return the CMake calls that set language, headers and libraries of a target."""
    lines = [
        f"target_compile_features({target} {scope} c_std_99 cxx_std_17)",
        f"target_include_directories({target} {scope}",
        "  $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include>",
        f"  $<INSTALL_INTERFACE:{_installed_includes(package)}>)",
    ]
    if package.dependencies:
        kind = "TARGETS" if package.build_type == AMENT_CMAKE else "LIBRARIES"
        lines.append(f"target_link_libraries({target} {scope}")
        lines += [f"  ${{{name}_{kind}}}" for name in package.dependencies]
        lines.append(")")
    return "".join(f"{line}\n" for line in lines)


def _installed_includes(package: NewPackage) -> str:
    return "include/${PROJECT_NAME}" if package.build_type == AMENT_CMAKE else "include"


def _ament_export(package: NewPackage) -> str:
    lines = [
        'ament_export_include_directories("include/${PROJECT_NAME}")',
        f"ament_export_libraries({package.library_name})",
        "ament_export_targets(export_${PROJECT_NAME})",
        *(f"ament_export_dependencies({name})" for name in package.dependencies),
    ]
    return "".join(f"{line}\n" for line in lines)


_RUST_MAIN: Final = """\
fn main() {{
    println!("Hi from {name}.");
}}
"""

_LIBRARY: Final = """\
/// What this library says.
pub fn greeting() -> &'static str {{
    "Hi from {name}."
}}

#[cfg(test)]
mod tests {{
    use super::*;

    #[test]
    fn it_greets() {{
        assert!(greeting().ends_with("{name}."));
    }}
}}
"""


def cargo_files(package: NewPackage, path: str) -> Iterator[Step]:
    """Yield the steps that create the folders and files of a Rust package.

    Cargo requires a target: a package without node and library gets a program of its own name.
    """
    source = join_path(path, "src")
    yield Note("creating source folder")
    yield Folder(source)
    yield File(join_path(path, "Cargo.toml"), _cargo_toml(package))
    if package.node_name or not package.library_name:
        yield File(join_path(source, "main.rs"), _RUST_MAIN.format(name=package.name))
    if package.library_name:
        yield File(join_path(source, "lib.rs"), _LIBRARY.format(name=package.name))


def _cargo_toml(package: NewPackage) -> str:
    import json

    # A JSON string is also a TOML string.
    lines = [
        "[package]",
        f"name = {json.dumps(package.name)}",
        'version = "0.0.0"',
        f"description = {json.dumps(package.description, ensure_ascii=False)}",
        'edition = "2021"',
        "",
    ]
    if package.library_name:
        name = package.library_name.replace("-", "_")
        lines += ["[lib]", f"name = {json.dumps(name)}", 'path = "src/lib.rs"', ""]
    if package.node_name:
        lines += ["[[bin]]", f"name = {json.dumps(package.node_name)}", 'path = "src/main.rs"', ""]
    lines += ["[dependencies]", *(f'{json.dumps(name)} = "*"' for name in package.dependencies)]
    return "\n".join([*lines, ""])
