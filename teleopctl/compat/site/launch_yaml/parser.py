"""``launch_yaml.parser``."""

from typing import ClassVar

from launch.frontend.parser import Parser as _Parser


class Parser(_Parser):
    """Reads launch files in YAML."""

    language: ClassVar[str | None] = "yaml"

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """Return the endings of such files."""
        return {"yaml", "yml"}
