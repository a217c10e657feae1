"""Creation of new packages, as by ``ros2 pkg create``."""

from teleopctl.packages.new.creating import check_package, create_package
from teleopctl.packages.new.package import BUILD_TYPES, NewPackage, license_names

__all__ = ["BUILD_TYPES", "NewPackage", "check_package", "create_package", "license_names"]
