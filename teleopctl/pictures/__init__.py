"""Camera pictures: conversion of image messages to pixels, and to formats that browsers show.

May import `interfaces`, and what every package may: `base`, `errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.pictures.cameras import (
        DEPTH_ENCODINGS as DEPTH_ENCODINGS,
        camera_name as camera_name,
        camera_topics as camera_topics,
    )
    from teleopctl.pictures.messages import (
        COMPRESSED as COMPRESSED,
        RAW as RAW,
        depths_of as depths_of,
        image_of as image_of,
        picture_of as picture_of,
    )
    from teleopctl.pictures.picture import (
        GreyScaling as GreyScaling,
        Picture as Picture,
        PictureError as PictureError,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
