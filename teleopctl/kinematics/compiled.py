"""Compiled MuJoCo models of robots for kinematics, cached in the user's folder.

A model is compiled once: reading the meshes of an arm takes MuJoCo a second, loading the compiled
model a millisecond. It is kept by a hash of all that it is made from: the description, the world,
and path, size and time of each of their files.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np
import xxhash
from lxml import etree

from teleopctl.base import __version__
from teleopctl.base.folders import cache_dir
from teleopctl.errors import TeleopctlError
from teleopctl.kinematics.poses import Array
from teleopctl.kinematics.self_collisions import ALWAYS_SHARE, touching_shares
from teleopctl.packages import resolve_uri
from teleopctl.robot import Joints, Mesh, RobotDescription

if TYPE_CHECKING:
    from teleopctl.robot import World

# Changed with what is written into a file, or with how it is computed.
_EDITION = "1"
_FOLDER, _SUFFIX = "kinematics", ".model"
# Files that are kept; those used longest ago are removed. One has some 100 kB to a few MB.
_MOST_KEPT = 32
# Random positions by which pairs of links are found that touch always.
_SAMPLES = 400
_DIRECTORIES = ("assetdir", "meshdir", "texturedir")


class CompiledModel(NamedTuple):
    """Compiled model of a robot with its root link fixed, with its joints and bodies.

    Attributes:
        mj_model: The ``mujoco.MjModel``, without shapes that are only drawn.
        start: Starting positions, as MuJoCo's ``qpos``.
        warnings: What was repaired or left out in the description, one sentence each.
        touching: Pairs of links that touch at nearly all joint positions, in alphabetical order.
        spec: The ``mujoco.MjSpec``; None if the model was loaded from the cache.
    """

    # Any: MuJoCo's classes have no types.
    mj_model: Any
    start: Array
    warnings: tuple[str, ...]
    touching: tuple[tuple[str, str], ...]
    spec: Any = None


def compiled_model(
    description: RobotDescription, joints: Joints, world: World | None = None
) -> CompiledModel:
    """Return the compiled model of a robot, from the cache if it is there.

    Args:
        description: The robot.
        joints: Its joints.
        world: World in which the robot stands; None for free space, without ground.

    Raises:
        InvalidDescriptionError: MuJoCo cannot build the robot.
    """
    file = Path(cache_dir()) / _FOLDER / f"{_key(description, world)}{_SUFFIX}"
    found = _load(file)
    if found is None:
        found = build_compiled(description, joints, world)
        _store(file, found)
    return found


def build_compiled(
    description: RobotDescription, joints: Joints, world: World | None = None
) -> CompiledModel:
    """Compile the model of a robot, with its spec; see `compiled_model`."""

    def prepare(spec: mujoco.MjSpec) -> None:
        # Meshes that are only drawn are most of the memory, and of the time to load it.
        spec.compiler.discardvisual = True
        if world is None:
            _remove_ground(spec)

    # Its import takes as long as that of MuJoCo, and a model from the cache does not need it.
    from teleopctl.mujoco_model import build_model

    built = build_model(description, prepare, world, fixed_base=True)
    model = built.mj_model
    data = mujoco.MjData(model)
    built.put_at_start(model, data)
    start = np.array(data.qpos)
    numbers = {model.body(n).name: n for n in range(model.nbody)}
    links = {link: numbers[link] for link in description.links if link in numbers}
    shares = touching_shares(model, joints, links, start, _SAMPLES)
    touching = tuple(pair for pair, share in shares.items() if share >= ALWAYS_SHARE)
    warnings = [
        f"'{first}' and '{second}' touch at nearly all joint positions: they are allowed to"
        for first, second in touching
    ]
    return CompiledModel(model, start, (*built.warnings, *warnings), touching, built.spec)


# Any: MuJoCo's classes have no types.
def _remove_ground(spec: Any) -> None:
    """Disable collisions of the ground, on which a robot without a world is simulated."""
    for geom in spec.geoms:
        if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
            geom.contype = geom.conaffinity = 0


# --- files --------------------------------------------------------------------------------------


def _load(file: Path) -> CompiledModel | None:
    """Return the model in a file; None if there is none, or it is damaged."""
    try:
        content = file.read_bytes()
        with suppress(OSError):  # a folder that may be read only
            os.utime(file)
        checksum, _, rest = content.partition(b"\n")
        if xxhash.xxh3_128_hexdigest(rest).encode() != checksum:
            return None
        header, _, model = rest.partition(b"\n")
        facts = json.loads(header)
        return CompiledModel(
            mujoco.MjModel.from_binary_path("model.mjb", {"model.mjb": model}),
            np.array(facts["start"], np.float64),
            tuple(facts["warnings"]),
            tuple((first, second) for first, second in facts["touching"]),
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _store(file: Path, compiled: CompiledModel) -> None:
    """Write a model to a file, and remove the files used longest ago."""
    model = np.zeros(mujoco.mj_sizeModel(compiled.mj_model), np.uint8)
    mujoco.mj_saveModel(compiled.mj_model, None, model)
    facts = {
        "start": compiled.start.tolist(),
        "warnings": compiled.warnings,
        "touching": compiled.touching,
    }
    content = json.dumps(facts).encode() + b"\n" + model.tobytes()
    checksum = xxhash.xxh3_128_hexdigest(content).encode()
    # A cache that cannot be written costs time only.
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        # Other processes may write the same file.
        unfinished = file.with_suffix(f".{os.getpid()}")
        unfinished.write_bytes(checksum + b"\n" + content)
        unfinished.replace(file)
        kept = sorted(
            file.parent.glob(f"*{_SUFFIX}"), key=lambda each: each.stat().st_mtime, reverse=True
        )
        for old in kept[_MOST_KEPT:]:
            old.unlink(missing_ok=True)


# --- what a model is made from ------------------------------------------------------------------


def _key(description: RobotDescription, world: World | None) -> str:
    """Return a hash of all inputs of a model."""
    digest = xxhash.xxh3_128()
    # Without CoACD, hollow meshes are not cut into convex pieces.
    parts = [_EDITION, __version__, mujoco.mj_versionString(), str(find_spec("coacd") is None)]
    parts += [description.urdf, *_files_of(description)]
    if world is not None:
        parts += _parts(world)
        if world.description is not None:
            parts += _files_of(world.description, world.path.parent)
        elif world.scene is None:
            parts += _mjcf_files(world.path)
    for part in parts:
        digest.update(f"{len(part)}:{part}".encode())
    return digest.hexdigest()


def _files_of(description: RobotDescription, folder: Path | None = None) -> Iterator[str]:
    """Yield the identity of each file of a description: meshes, and an MJCF file with its own."""
    geometries = [
        shape.geometry
        for link in description.links.values()
        for shapes in (link.visuals, link.collisions)
        for shape in shapes
    ]
    for uri in sorted({each.uri for each in geometries if isinstance(each, Mesh)}):
        try:
            yield _identity((folder or Path()) / resolve_uri(uri))
        except (TeleopctlError, ValueError):
            yield f"{uri} is not found"
    if description.mjcf is not None:
        yield from _mjcf_files(description.mjcf)


def _mjcf_files(path: Path) -> Iterator[str]:
    """Yield the identities of an MJCF file, of the files that it includes, and of their assets."""
    folder = path.absolute().parent
    # MuJoCo accepts what XML forbids, such as two hyphens in a comment.
    parser = etree.XMLParser(recover=True, resolve_entities=False)
    pending, seen, names, folders = [path.absolute()], set[Path](), set[str](), {folder}
    while pending:
        file = pending.pop()
        if file in seen:
            continue
        seen.add(file)
        yield _identity(file)
        try:
            root = etree.parse(str(file), parser).getroot()
        except (OSError, etree.XMLSyntaxError):
            continue
        for element in root.iter(etree.Element):
            name = element.get("file")
            if element.tag == "include" and name:
                pending += [folder / name, file.parent / name]
            elif name:
                names.add(name)
            folders.update(folder / each for key in _DIRECTORIES if (each := element.get(key)))
    for name in sorted(names):
        for each in sorted(folders):
            if (each / name).is_file():
                yield _identity(each / name)


def _parts(value: object) -> Iterator[str]:
    """Yield the content of a tree of records: texts, numbers, XML, and the identity of files."""
    if isinstance(value, Path):
        yield _identity(value)
    elif isinstance(value, etree._Element):  # noqa: SLF001 - the type of lxml's elements
        yield etree.tostring(value, encoding="unicode")
    elif dataclasses.is_dataclass(value):
        yield type(value).__name__
        for field in dataclasses.fields(value):
            yield from _parts(getattr(value, field.name))
    elif isinstance(value, tuple | list | frozenset):
        yield f"{len(value)}"
        for each in value:
            yield from _parts(each)
    elif isinstance(value, Mapping):
        yield f"{len(value)}"
        for key, each in value.items():
            yield repr(key)
            yield from _parts(each)
    else:
        yield repr(value)


def _identity(path: Path) -> str:
    """Return a file's path, size and time of change."""
    try:
        found = path.stat()
    except OSError:
        return f"{path} is not there"
    return f"{path.absolute()} {found.st_size} {found.st_mtime_ns}"
