"""Pages that the documentation site makes itself: README as its start, the API from front doors."""

from __future__ import annotations

import ast
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PUBLIC_NAMES = ROOT / "tests" / "public_names.txt"
# What programs and plug-ins use besides the front doors: of these, every public name.
MODULES = ("cli.console", "cli.verb", "errors", "plugins")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the generated pages."""
    start = (ROOT / "README.md").read_text(encoding="utf-8").replace("(docs/", "(")
    files.append(File.generated(config, "index.md", content=start))
    lines = PUBLIC_NAMES.read_text(encoding="utf-8").split()
    for package in dict.fromkeys(line.split(".")[1] for line in lines):
        text = _reference(package)
        files.append(File.generated(config, f"reference/{package}.md", content=text))
    for module in MODULES:
        options = "{heading_level: 1, show_root_full_path: true}"
        text = f"::: teleopctl.{module}\n    options: {options}\n"
        files.append(File.generated(config, f"reference/{module}.md", content=text))
    return files


def _reference(package: str) -> str:
    """A page that documents every public name of a folder where it is defined."""
    door = ast.parse((ROOT / "teleopctl" / package / "__init__.py").read_text(encoding="utf-8"))
    homes = {
        alias.name: statement.module
        for statement in ast.walk(door)
        if isinstance(statement, ast.ImportFrom) and (statement.module or "").count(".") > 1
        for alias in statement.names
    }
    lines = [f"# teleopctl.{package}", "", ast.get_docstring(door) or "", ""]
    for name in sorted(homes, key=str.casefold):
        lines += [f"::: {homes[name]}.{name}", ""]
    return "\n".join(lines)
