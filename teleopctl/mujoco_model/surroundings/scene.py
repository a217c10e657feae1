"""Surroundings of the robot: ground, light and sky.

The scene is for viewers and cameras. Physics uses only its ground plane, which lies at z = 0 of the
world frame. A world with its own ground or sky keeps those.
"""

from __future__ import annotations

import mujoco

GROUND_NAME = "ground_plane"
# A name that no description uses.
_GROUND_GEOM = "teleopctl/ground"
_GROUND_MATERIAL = "ground"

# The side of one tile of the ground's chequer, in metres: a scale to judge distances by.
_TILE_M = 0.5

_ZENITH = [0.62, 0.74, 0.88]
_HORIZON = [0.86, 0.9, 0.95]
_SUN = "teleopctl/sun"
_DIRECTIONAL = mujoco.mjtLightType.mjLIGHT_DIRECTIONAL
# Brightness of the headlight, and that in a world with a sun: Gazebo's sun is brighter than the
# default one, and with more light its ground of 0.8 would be white.
_HEADLIGHT, _BESIDE_A_SUN = 0.35, 0.1


def add_scene(spec: mujoco.MjSpec) -> None:
    """Add ground, sun and sky to a ``mujoco.MjSpec``, each unless the spec has one.

    The ground has a body of its own, so that its contacts with the robot's base can be
    distinguished from those between two links of the robot.

    Args:
        spec: The ``mujoco.MjSpec`` to extend.
    """
    if all(texture.type != mujoco.mjtTexture.mjTEXTURE_SKYBOX for texture in spec.textures):
        _add_sky(spec)
    add_ground(spec)
    add_default_sun(spec)


def add_default_sun(spec: mujoco.MjSpec, *, lit: bool = False) -> None:
    """Add the default sun if there is no directional light, and set the headlight to match.

    With two suns all light colours would be white.

    Args:
        spec: The ``mujoco.MjSpec`` to edit.
        lit: Whether the robot's own file defines the lighting if it has lights.
    """
    if (own := spec.light(_SUN)) is not None:
        spec.delete(own)
    shines = any(light.type == _DIRECTIONAL for light in spec.lights)
    if not shines and not (lit and len(spec.lights)):
        _add_sun(spec)
    if not lit:
        _set_headlight(spec, _BESIDE_A_SUN if shines else _HEADLIGHT)


def add_ground(spec: mujoco.MjSpec) -> None:
    """Add a ground plane to a spec, unless the spec has a plane."""
    if all(geom.type != mujoco.mjtGeom.mjGEOM_PLANE for geom in spec.geoms):
        _add_ground(spec, _free_name(GROUND_NAME, {body.name for body in spec.bodies}))


def remove_ground(spec: mujoco.MjSpec) -> None:
    """Remove the ground plane that `add_ground` added from a spec, if there."""
    geom = spec.geom(_GROUND_GEOM)
    if geom is not None:
        spec.delete(geom.parent)
        spec.delete(spec.material(_GROUND_MATERIAL))
        spec.delete(spec.texture(_GROUND_MATERIAL))


def complete_scene(spec: mujoco.MjSpec) -> None:
    """Add ground, light and sky to a robot's own MJCF scene where it lacks them.

    Args:
        spec: The ``mujoco.MjSpec`` to extend.
    """
    if all(texture.type != mujoco.mjtTexture.mjTEXTURE_SKYBOX for texture in spec.textures):
        _add_sky(spec)
    if not any(geom.contype or geom.conaffinity for geom in spec.worldbody.geoms):
        _add_ground(spec, _free_name(GROUND_NAME, {body.name for body in spec.bodies}))
    if not len(spec.lights):
        _add_sun(spec)
        _set_headlight(spec, _HEADLIGHT)


def _free_name(wanted: str, taken: set[str]) -> str:
    while wanted in taken:
        wanted += "_"
    return wanted


def _add_sky(spec: mujoco.MjSpec) -> None:
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=_ZENITH,
        rgb2=_HORIZON,
        width=256,
        height=256 * 6,
    )
    spec.visual.rgba.haze = [*_HORIZON, 1.0]


def _add_ground(spec: mujoco.MjSpec, name: str) -> None:
    spec.add_texture(
        name=_GROUND_MATERIAL,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        mark=mujoco.mjtMark.mjMARK_EDGE,
        rgb1=[0.72, 0.73, 0.74],
        rgb2=[0.64, 0.65, 0.67],
        markrgb=[0.55, 0.56, 0.58],
        width=256,
        height=256,
    )
    material = spec.add_material(name=_GROUND_MATERIAL, reflectance=0.15, texuniform=True)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = _GROUND_MATERIAL
    # One texture holds two by two tiles.
    material.texrepeat = [0.5 / _TILE_M, 0.5 / _TILE_M]
    body = spec.worldbody.add_body(name=name)
    body.add_geom(
        name=_GROUND_GEOM,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0.0, 0.0, 0.05],  # zero half-lengths: an infinite plane
        material=_GROUND_MATERIAL,
        group=1,
    )


def _add_sun(spec: mujoco.MjSpec) -> None:
    spec.worldbody.add_light(
        name=_SUN,
        type=_DIRECTIONAL,
        pos=[1.4, -1.8, 4.0],
        dir=[-0.35, 0.45, -1.0],
        diffuse=[0.75, 0.75, 0.72],
        specular=[0.25, 0.25, 0.25],
        castshadow=True,
    )
    # The edge of the shadow map shows as specks on the ground: keep it far from the robot.
    spec.visual.map.shadowclip = 2.0


def _set_headlight(spec: mujoco.MjSpec, diffuse: float) -> None:
    headlight = spec.visual.headlight
    headlight.ambient = [0.35, 0.35, 0.35]
    headlight.diffuse = [diffuse, diffuse, diffuse]
    headlight.specular = [0.1, 0.1, 0.1]
