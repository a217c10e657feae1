"""Pages that the documentation site makes itself: README as its start, the API from front doors."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]

# The packages that programs import, in the order in which a reader meets them.
PACKAGES = ("node", "interfaces", "wire", "tf", "robot", "mujoco_model", "control", "sim", "launch")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    start = (ROOT / "README.md").read_text(encoding="utf-8").replace("(docs/", "(")
    files.append(File.generated(config, "index.md", content=start))
    for package in PACKAGES:
        text = _reference(f"teleopctl.{package}")
        files.append(File.generated(config, f"reference/{package}.md", content=text))
    return files


def _reference(name: str) -> str:
    """A page that documents every public name of a package where it is defined."""
    module = import_module(name)
    lines = [f"# {name}", "", str(module.__doc__ or "").strip(), ""]
    for public in sorted(getattr(module, "__all__", ()), key=str.casefold):
        value = getattr(module, public)
        home = getattr(value, "__module__", None)
        if not isinstance(home, str) or not home.startswith("teleopctl."):
            home = name
        lines += [f"::: {home}.{getattr(value, '__name__', public)}", ""]
    return "\n".join(lines)
