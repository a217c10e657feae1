"""The sources in C++ of a new package that CMake builds."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from teleopctl.packages.new.package import NewPackage
from teleopctl.packages.new.steps import File, Step, joined

_MAIN: Final = """\
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
    """Yield the source and header files of a C++ package."""
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
        yield File(joined(source, f"{package.node_name}.cpp"), _MAIN.format(**names))
    if library:
        yield File(joined(include, f"{library}.hpp"), _HEADER.format(**names))
        yield File(joined(source, f"{library}.cpp"), _SOURCE.format(**names))
        yield File(joined(include, "visibility_control.h"), _VISIBILITY.format(**names))


def _identifier(name: str) -> str:
    return name.replace("-", "_").replace(".", "_")
