"""The files of a new ``ament_cargo`` package in Rust, besides its manifest."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Final

from teleopctl.packages.new.package import NewPackage
from teleopctl.packages.new.steps import File, Folder, Note, Step, joined

_MAIN: Final = """\
fn main() {{
    println!("Hi from {name}.");
}}
"""

_LIBRARY: Final = """\
/// What this library says.
pub fn greeting() -> &'static str {{
    "Hi from {name}."
}}

#[cfg(test)]
mod tests {{
    use super::*;

    #[test]
    fn it_greets() {{
        assert!(greeting().ends_with("{name}."));
    }}
}}
"""


def cargo_files(package: NewPackage, place: str) -> Iterator[Step]:
    """Return the steps that make a Rust package's files.

    Cargo wants a target: a package without node and library gets a program of its own name.
    """
    source = joined(place, "src")
    yield Note("creating source folder")
    yield Folder(source)
    yield File(joined(place, "Cargo.toml"), _cargo_toml(package))
    if package.node_name or not package.library_name:
        yield File(joined(source, "main.rs"), _MAIN.format(name=package.name))
    if package.library_name:
        yield File(joined(source, "lib.rs"), _LIBRARY.format(name=package.name))


def _cargo_toml(package: NewPackage) -> str:
    # A text in JSON is one in TOML too.
    lines = [
        "[package]",
        f"name = {json.dumps(package.name)}",
        'version = "0.0.0"',
        f"description = {json.dumps(package.description, ensure_ascii=False)}",
        'edition = "2021"',
        "",
    ]
    if package.library_name:
        name = package.library_name.replace("-", "_")
        lines += ["[lib]", f"name = {json.dumps(name)}", 'path = "src/lib.rs"', ""]
    if package.node_name:
        lines += ["[[bin]]", f"name = {json.dumps(package.node_name)}", 'path = "src/main.rs"', ""]
    lines += ["[dependencies]", *(f'{json.dumps(name)} = "*"' for name in package.dependencies)]
    return "\n".join([*lines, ""])
