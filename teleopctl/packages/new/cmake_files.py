"""The CMake scripts of a new package."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from teleopctl.packages.new.package import AMENT_CMAKE, NewPackage
from teleopctl.packages.new.steps import File, Step, joined

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
    """Yield the build files of a CMake package."""
    yield File(joined(folder, "CMakeLists.txt"), _cmake_lists(package))
    if package.build_type == AMENT_CMAKE:
        return
    name = package.name
    config = _CONFIG.format(name=name)
    if package.library_name:
        config += f"set({name}_LIBRARIES {package.library_name})\n"
    if package.node_name:
        config += f"set({name}_EXECUTABLE {package.node_name})\n"
    yield File(joined(folder, f"{name}Config.cmake.in"), config)
    version = _CONFIG_VERSION.format(name=name)
    yield File(joined(folder, f"{name}ConfigVersion.cmake.in"), version)


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
    """Language, headers and libraries of a target."""
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
