"""``launch.utilities.typing_file_path``."""

import os
from pathlib import Path
from typing import TypeVar

FilePath = TypeVar("FilePath", str, bytes, "os.PathLike[str]", Path)
