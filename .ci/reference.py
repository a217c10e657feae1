"""Pages that the documentation site generates: README and its neighbours, and the public API."""

from __future__ import annotations

import ast
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
# What programs, tests and plug-ins may rely on; all other names are internal.
PUBLIC_NAMES = (ROOT / "tests" / "public_names.txt").read_text(encoding="utf-8").split()
# Of these modules, every public name.
MODULES = ("cli.console", "cli.verb", "errors", "plugins")
# Files of the project's root folder that are pages of the site.
PROJECT_FILES = {
    "index.md": "README.md",
    "contributing.md": "CONTRIBUTING.md",
    "changelog.md": "CHANGELOG.md",
}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    for page, name in PROJECT_FILES.items():
        text = (ROOT / name).read_text(encoding="utf-8").replace("(docs/", "(")
        for target, source in PROJECT_FILES.items():
            text = text.replace(f"({source})", f"({target})")
        files.append(File.generated(config, page, content=text))
    style = (ROOT / ".ci" / "site.css").read_text(encoding="utf-8")
    files.append(File.generated(config, "site.css", content=style))
    for package in dict.fromkeys(name.rpartition(".")[0] for name in PUBLIC_NAMES):
        page = f"reference/{package.removeprefix('teleopctl.')}.md"
        files.append(File.generated(config, page, content=_reference(package)))
    for module in MODULES:
        options = "{heading_level: 1, show_root_full_path: true}"
        text = f"::: teleopctl.{module}\n    options: {options}\n"
        files.append(File.generated(config, f"reference/{module}.md", content=text))
    return files


def _reference(package: str) -> str:
    """A page that documents every public name of a package where it is defined."""
    file = ROOT.joinpath(*package.split("."), "__init__.py")
    door = ast.parse(file.read_text(encoding="utf-8"))
    homes = {
        alias.name: statement.module
        for statement in ast.walk(door)
        if isinstance(statement, ast.ImportFrom) and statement.module != "teleopctl.base.typed"
        for alias in statement.names
        if f"{package}.{alias.name}" in PUBLIC_NAMES
    }
    text = (ast.get_docstring(door) or "").partition("(For pytest")[0]
    lines = [f"# {package}", "", text, ""]
    for name in sorted(homes, key=str.casefold):
        lines += [f"::: {homes[name]}.{name}", ""]
    return "\n".join(lines)
