"""Search for files that SDF names: ``model://``, ``package://``, ``file://``, paths, Fuel URIs."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote

from lxml import etree

from teleopctl.errors import NotFoundError, TeleopctlError
from teleopctl.packages import lookup_package, resolve_uri

# Environment variables with the model search paths of new Gazebo and Gazebo Classic.
_VARIABLES = (
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
)
# Number of parent folders of a file that are searched for a folder ``models``.
_LEVELS = 5
_FUEL = re.compile(r"https?://[^/]*(?:fuel|app)\.(?:gazebosim|ignitionrobotics)\.org/.*/models/")


def find_file(uri: str, folder: Path) -> Path:
    """Return the path that a URI in an SDF file names, by Gazebo's search paths; raise if none.

    Args:
        uri: URI or path as written in the file.
        folder: Folder of the file.

    Raises:
        NotFoundError: The file is not found.
    """
    fuel = _FUEL.match(uri)
    scheme, separator, rest = uri.partition("://")
    if fuel is not None:
        candidates = _in_fuel(unquote(uri[fuel.end() :]), folder)
    elif scheme in ("model", "package") and separator:
        candidates = _in_models(unquote(rest), folder)
    elif scheme == "file" and separator:
        path = Path(unquote(rest))
        candidates = iter((path if path.is_absolute() else folder / path,))
        if not path.is_absolute():
            candidates = _in_models(str(path), folder)
    elif separator:
        raise NotFoundError(f"{uri} is not downloaded: models are read from local folders")
    else:
        candidates = _in_models(uri, folder)
    for candidate in candidates:
        try:
            if candidate.exists():
                return candidate
        except (OSError, ValueError) as error:
            raise NotFoundError(f"{uri} is no path") from error
    raise NotFoundError(
        f"{uri} is not found beside {folder}, on GZ_SIM_RESOURCE_PATH or GAZEBO_MODEL_PATH, or "
        "among the packages"
    )


def model_file(path: Path) -> Path:
    """Return a model folder's newest SDF file by ``model.config``; a file's path unchanged.

    Raises:
        NotFoundError: The folder has no SDF file.
    """
    if path.is_file():
        return path
    found: list[tuple[tuple[int, ...], str]] = []
    try:
        parser = etree.XMLParser(resolve_entities=False, remove_comments=True)
        config = etree.fromstring((path / "model.config").read_bytes(), parser)
    except (OSError, etree.XMLSyntaxError):
        config = None
    for element in [] if config is None else config.findall("sdf"):
        words = (element.get("version") or "0").split(".")
        version = tuple(int(word) for word in words if word.isdecimal() and len(word) < 5)
        found.append((version, (element.text or "").strip()))
    for _, name in sorted(found, reverse=True):
        if (path / name).is_file():
            return path / name
    if (path / "model.sdf").is_file():
        return path / "model.sdf"
    raise NotFoundError(f"There is no model in {path}: neither model.config nor model.sdf")


def gazebo_models(uri: str = "") -> list[Path]:
    """Return the SDF files of the models in a folder, or in all of Gazebo's search folders.

    Args:
        uri: Folder; empty for Gazebo's environment variables and ``~/.gazebo/models``.
    """
    named = (part for name in _VARIABLES for part in os.environ.get(name, "").split(os.pathsep))
    folders = [*map(Path, filter(None, named)), Path.home() / ".gazebo/models"]
    found: dict[Path, None] = {}
    for each in [uri] if uri else folders:
        with suppress(OSError, NotFoundError):
            folder = resolve_uri(str(each))
            for inner in sorted(folder.iterdir()):
                if (inner / "model.config").is_file():
                    with suppress(NotFoundError):
                        found[model_file(inner).absolute()] = None
    return list(found)


def _in_models(name: str, folder: Path) -> Iterator[Path]:
    yield folder / name
    first, _, rest = name.partition("/")
    for start in _folders(folder):
        yield start / name
    found = None
    try:
        found = lookup_package(first)
    except TeleopctlError:
        found = None
    if found is not None:
        yield resolve_uri(f"package://{name}")
    # Files in a model's folder may name the model itself.
    for parent in (folder, *folder.parents):
        if parent.name == first:
            yield parent / rest


def _in_fuel(name: str, folder: Path) -> Iterator[Path]:
    """Yield possible paths of a Fuel model: in Gazebo's cache, or among other models."""
    parts = name.strip("/").split("/")
    for cache in (Path.home() / ".gz/fuel", Path.home() / ".ignition/fuel"):
        for versions in cache.glob(f"*/*/models/{glob.escape(parts[0].lower())}/"):
            yield from sorted(versions.iterdir(), reverse=True)
    yield from _in_models(parts[0], folder)


def _folders(folder: Path) -> Iterator[Path]:
    for variable in _VARIABLES:
        yield from map(Path, filter(None, os.environ.get(variable, "").split(os.pathsep)))
    for parent in (folder, *folder.parents[:_LEVELS]):
        yield parent
        yield parent / "models"
    yield Path.home() / ".gazebo/models"
