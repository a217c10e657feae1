"""Fixtures: virtual environment of a user, with teleopctl from its wheel and no configuration."""

import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BUILD = "import sys; from hatchling.build import build_wheel; print(build_wheel(sys.argv[1]))"


@pytest.fixture(scope="session")
def wheel(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    built = subprocess.run(
        [sys.executable, "-c", BUILD, str(folder)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    return Path(folder) / built.stdout.split()[-1]


@pytest.fixture(scope="session")
def users_python(tmp_path_factory, wheel) -> Path:
    """Fixture: interpreter of a virtual environment with teleopctl and its dependencies."""
    folder = tmp_path_factory.mktemp("user") / "venv"
    venv.create(folder, with_pip=False)
    scheme = {"base": str(folder), "platbase": str(folder)}
    packages = Path(sysconfig.get_path("purelib", "venv", scheme))
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(packages)
    # Dependencies are those of this environment; the wheel's teleopctl precedes this checkout's.
    dependencies = [path for path in sys.path if path.endswith(("site-packages", "dist-packages"))]
    packages.joinpath("dependencies.pth").write_text("\n".join(dependencies), encoding="utf-8")
    scripts = Path(sysconfig.get_path("scripts", "venv", scheme))
    return scripts / Path(sys.executable).name
