"""Creation of a new package, as by ``ros2 pkg create``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from datetime import date
from pathlib import Path

from teleopctl.errors import RefusedError, SystemFailureError
from teleopctl.packages.new.package import (
    AMENT_CARGO,
    AMENT_PYTHON,
    File,
    Folder,
    NewPackage,
    Note,
    Step,
    check_names,
    join_path,
    license_text,
    package_xml,
)
from teleopctl.packages.new.source_files import cargo_files, cmake_files, cpp_files, python_files


def create_package(package: NewPackage, folder: str, report: Callable[[str], object]) -> None:
    """Create a new ROS package's folder and files; report each before it is created.

    Args:
        package: Options of the package.
        folder: Folder in which the package's folder is created.
        report: Called with a line of text before each file and folder is created.

    Raises:
        UsageError: A name is invalid.
        RefusedError: A file or folder of that name exists.
        SystemFailureError: The files cannot be written.
    """
    check_package(package, folder)
    path = join_path(folder, package.name)
    try:
        for step in _steps(package, path):
            _take(step, report)
    except OSError as error:
        raise SystemFailureError(f"{error.filename}: {error.strerror}") from error


def check_package(package: NewPackage, folder: str) -> None:
    """Raise if a new package has an invalid name, or if its folder exists.

    Raises:
        UsageError: A name is invalid.
        RefusedError: A file or folder of that name exists.
    """
    check_names(package)
    path = join_path(folder, package.name)
    if Path(path).exists():
        raise RefusedError(
            f"Aborted! The directory already exists: {path}",
            hint="Either remove the directory or choose a different destination directory or "
            "package name.",
        )


def _steps(package: NewPackage, path: str) -> Iterator[Step]:
    yield Folder(path)
    yield File(join_path(path, "package.xml"), package_xml(package))
    if package.build_type == AMENT_PYTHON:
        yield from python_files(package, path)
    elif package.build_type == AMENT_CARGO:
        yield from cargo_files(package, path)
    else:
        source, include = join_path(path, "src"), join_path(path, "include", package.name)
        yield Note("creating source and include folder")
        yield Folder(source)
        yield Folder(include)
        yield from cmake_files(package, path)
        yield from cpp_files(package, source, include)
    text = license_text(package.license, package.maintainer_name, date.today().year)
    if text is not None:
        yield File(join_path(path, "LICENSE"), text, is_reported=False)


def _take(step: Step, report: Callable[[str], object]) -> None:
    match step:
        case Note(text):
            report(text)
        case Folder(path):
            report(f"creating folder {path}")
            Path(path).mkdir(parents=True, exist_ok=True)
        case File(path, text, is_reported):
            if is_reported:
                report(f"creating {path}")
            with Path(path).open("w", encoding="utf-8", newline="\n") as file:
                file.write(text)
