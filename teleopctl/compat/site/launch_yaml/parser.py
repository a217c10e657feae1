"""``launch_yaml.parser``."""

from typing import ClassVar

from launch.frontend.parser import Parser as _Parser


class Parser(_Parser):
    """Parser of YAML launch files."""

    language: ClassVar[str | None] = "yaml"

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """Return the file extensions of YAML launch files."""
        return {"yaml", "yml"}
