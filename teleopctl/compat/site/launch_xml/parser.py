"""``launch_xml.parser``."""

from typing import ClassVar

from launch.frontend.parser import Parser as _Parser


class Parser(_Parser):
    """Parser of XML launch files."""

    language: ClassVar[str | None] = "xml"

    @classmethod
    def get_file_extensions(cls) -> set[str]:
        """Return the file extensions of XML launch files."""
        return {"xml"}
