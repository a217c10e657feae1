"""The light of the scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import viser

# Where each light comes from, and how strong it is. viser's own shines from straight above, so
# bright that what lies there is white in every colour.
_LIGHTS = (((1.2, -2.0, 2.6), 1.7), ((-2.0, 0.6, 0.8), 0.5))
_SKY = 0.7


def light(scene: viser.SceneApi) -> None:
    """Add lights without shadows to a scene."""
    scene.configure_default_lights(enabled=False, cast_shadow=False)
    scene.configure_environment_map("city", environment_intensity=_SKY)
    for number, (position, intensity) in enumerate(_LIGHTS):
        scene.add_light_directional(f"/light{number}", position=position, intensity=intensity)
