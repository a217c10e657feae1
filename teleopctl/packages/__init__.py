"""ROS packages: search by name, folders of their files, and their programs.

May import `base`, `errors` and `plugins` only.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.packages.components import (
        Component as Component,
        find_component as find_component,
        list_components as list_components,
    )
    from teleopctl.packages.distributions import builtin_package as builtin_package
    from teleopctl.packages.finding import (
        PACKAGE_PATH_VARIABLE as PACKAGE_PATH_VARIABLE,
        apply_source_hooks as apply_source_hooks,
        faults_of_search as faults_of_search,
        find_package as find_package,
        include_package_of as include_package_of,
        list_packages as list_packages,
        lookup_package as lookup_package,
        package_layers as package_layers,
        package_names as package_names,
        package_share as package_share,
        resolve_uri as resolve_uri,
        source_resources as source_resources,
    )
    from teleopctl.packages.installed_layout import (
        interfaces_elsewhere as interfaces_elsewhere,
        run_dependencies as run_dependencies,
    )
    from teleopctl.packages.modules import (
        installed_module_roots as installed_module_roots,
        source_module_root as source_module_root,
    )
    from teleopctl.packages.new import (
        BUILD_TYPES as BUILD_TYPES,
        NewPackage as NewPackage,
        check_package as check_package,
        create_package as create_package,
        license_names as license_names,
    )
    from teleopctl.packages.own_packages import own_prefix as own_prefix
    from teleopctl.packages.prefixes import search_paths as search_paths
    from teleopctl.packages.programs import (
        find_executable as find_executable,
        is_path as is_path,
    )
    from teleopctl.packages.records import Package as Package, PackageProgram as PackageProgram
    from teleopctl.packages.source_folders import enclosing_package as enclosing_package
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
