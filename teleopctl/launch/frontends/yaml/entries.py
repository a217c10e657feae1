"""The keys of one action: which are known, which are needed."""

from __future__ import annotations

from collections.abc import Iterable

from teleopctl.errors import did_you_mean
from teleopctl.launch.frontends.yaml.tree import Element
from teleopctl.launch.model.template import Template


class Entry:
    """A mapping with known keys.

    Args:
        element: The mapping.
        known: The keys that may stand in it, with hyphens or with underscores.

    Raises:
        TeleopctlError: When the element is no mapping, or has another key.
    """

    def __init__(self, element: Element, known: Iterable[str]) -> None:
        self._element = element
        self._fields: dict[str, Element] = {}
        keys = tuple(known)
        canonical = {key.replace("-", "_"): key for key in keys}
        for key, value in element.mapping(f"a mapping with {', '.join(keys)}").items():
            name = canonical.get(key.replace("-", "_"))
            if name is None:
                raise value.error(
                    f"unknown key '{key}', expected one of {', '.join(keys)}",
                    hint=did_you_mean(key, keys),
                )
            self._fields[name] = value

    def element(self, key: str) -> Element | None:
        """Return what stands under a key, or None."""
        return self._fields.get(key)

    def required_element(self, key: str) -> Element:
        """Return what stands under a key.

        Raises:
            TeleopctlError: When the key is missing.
        """
        if key not in self._fields:
            raise self._element.error(f"'{key}' is missing")
        return self._fields[key]

    def required(self, key: str) -> Template:
        """Return the text under a key; missing or malformed text is a TeleopctlError."""
        return self.required_element(key).template()

    def required_text(self, key: str) -> str:
        """Return the text under a key as it stands, without substitutions."""
        return self.required_element(key).text()

    def optional(self, key: str) -> Template | None:
        """Return the text under a key, or None where the key is missing."""
        element = self._fields.get(key)
        return None if element is None else element.template()
