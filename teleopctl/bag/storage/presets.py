"""rosbag2's words for how MCAP files are written, as what our writer can do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from teleopctl.bag.mcap_file.file_writer import CHUNK_BYTES, Compression
from teleopctl.errors import InvalidFileError, UnsupportedError, UsageError

PRESETS = ("none", "fastwrite", "zstd_fast", "zstd_small")
"""Storage preset profiles of rosbag2's MCAP plug-in."""

# The files keep their chunks and indexes in any case: they are what a crash leaves readable.
_OF_PRESETS = {
    "": Compression.ZSTD,
    "none": Compression.NONE,
    "fastwrite": Compression.NONE,
    "zstd_fast": Compression.ZSTD,
    "zstd_small": Compression.ZSTD,
}
_NAMES = {compression.value: compression for compression in Compression}


def chunk_settings(preset: str = "", config_file: Path | None = None) -> tuple[Compression, int]:
    """Compression and size of the chunks, in bytes.

    Args:
        preset: One of `PRESETS`; empty for zstd.
        config_file: YAML as rosbag2's MCAP plug-in reads it; wins over the preset.

    Raises:
        UsageError: There is no such preset.
        UnsupportedError: The file asks for something that our files never lack.
        InvalidFileError: The file cannot be read.
    """
    if preset not in _OF_PRESETS:
        raise UsageError(
            f"unknown MCAP storage preset profile '{preset}'",
            hint=f"There are {', '.join(PRESETS)}.",
        )
    compression, chunk_bytes = _OF_PRESETS[preset], CHUNK_BYTES
    for key, value in _read(config_file).items() if config_file else ():
        if key == "compression" and str(value).lower() in _NAMES:
            compression = _NAMES[str(value).lower()]
        elif key == "chunkSize" and isinstance(value, int) and value > 0:
            chunk_bytes = value
        elif key not in ("compressionLevel", "forceCompression") and value is not False:
            # A switch that is off asks for what is done anyway.
            raise UnsupportedError(
                f"{config_file}: '{key}: {value}' is not supported",
                hint="There are compression (None, Lz4 or Zstd) and chunkSize (bytes).",
            )
    return compression, chunk_bytes


# Any: YAML's values.
def _read(file: Path) -> dict[str, Any]:
    try:
        document = yaml.safe_load(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise InvalidFileError(f"Cannot read {file}: {error.strerror}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InvalidFileError(f"{file} is no YAML: {error}") from error
    if not isinstance(document or {}, dict):
        raise InvalidFileError(f"{file} is no mapping of settings")
    return document or {}
