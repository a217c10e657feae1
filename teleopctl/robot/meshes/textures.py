"""Where the pictures are that mesh files name, for all who read meshes: picture and physics."""

from __future__ import annotations

from pathlib import Path
from urllib.parse import unquote


def picture_places(mesh: Path, name: str) -> list[Path]:
    """Where a file may be that a mesh file names, the likeliest first.

    Beside the mesh by the name that it has, which COLLADA and glTF write as a part of a URI and
    tools on Windows with backslashes; else, as Gazebo looks for pictures, by its last part alone
    beside the mesh and in ``../materials/textures``.

    Args:
        mesh: The mesh file.
        name: What stands in it.
    """
    folder = mesh.parent
    plain = unquote(name).replace("\\", "/")
    last = plain.rpartition("/")[2]
    names = dict.fromkeys((name, unquote(name), plain))
    places = [folder / each for each in names]
    if last:
        places += [folder / last, folder.parent / "materials" / "textures" / last]
    return places
