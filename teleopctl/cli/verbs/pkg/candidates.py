"""What Tab offers for the verbs of ``pkg``."""

from __future__ import annotations

from teleopctl.cli.completion.completing import TypedWords


def manifest_tags(ctx: TypedWords, incomplete: str) -> list[str]:
    """Return the manifest tags of the package on the line."""
    from lxml import etree

    from teleopctl import packages

    parser = etree.XMLParser(resolve_entities=False, remove_comments=True, remove_pis=True)

    try:
        package = packages.lookup_package(ctx.params.get("name") or "")
        if package is None:
            return []
        root = etree.parse(package.folder / "package.xml", parser).getroot()
    except (OSError, etree.XMLSyntaxError):
        return []
    return sorted(
        {tag for tag in map(str, (each.tag for each in root)) if tag.startswith(incomplete)}
    )


def licenses(incomplete: str) -> list[str]:
    """Return the licenses whose text is known."""
    from teleopctl.packages import license_names

    return [name for name in license_names() if name.startswith(incomplete)]
