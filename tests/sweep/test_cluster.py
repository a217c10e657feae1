"""``teleopctl sim sweep --cluster``: real runs on workers of a real Dask scheduler."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from teleopctl.errors import RefusedError
from teleopctl.launch import find_launch_file
from teleopctl.sweep.cluster import file_transfer
from teleopctl.sweep.cluster.file_transfer import not_sent, pack_launch, unpack
from teleopctl.sweep.one_run import RunRequest
from teleopctl.testing import LONGEST_WAIT_S, RosGraph, eventually

# It says where it runs, and waits until there is a file.
WAITING = """
launch:
- arg: {name: wait_for}
- executable: {cmd: "PYTHON wait.py $(var wait_for)"}
""".replace("PYTHON", sys.executable)
WAIT = """import os, pathlib, sys, time
target = pathlib.Path(sys.argv[1])
draft = target.with_name(f"draft.{os.getpid()}")
draft.write_text(os.getcwd())
draft.rename(target.with_name(f"begun.{os.getpid()}"))
while not target.exists(): time.sleep(0.05)
"""
# A scheduler, and a worker that comes when it is asked for.
SERVER = """import asyncio, sys
from distributed import Scheduler, Worker
async def main():
    async with Scheduler(host="127.0.0.1", port=0, dashboard=False) as scheduler:
        print(scheduler.address, flush=True)
        await asyncio.to_thread(sys.stdin.readline)
        async with Worker(
            scheduler.address, name="under the desk", nthreads=1, local_directory=sys.argv[1]
        ):
            await scheduler.finished()
asyncio.run(main())
"""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A scheduler, that tells its address."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVER, str(tmp_path / "other")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    yield process
    process.kill()
    process.communicate()


@pytest.mark.nightly
def test_the_run_of_a_lost_worker_is_done_again_by_another(
    ros_without_router: RosGraph, tmp_path: Path, server: subprocess.Popen[str]
) -> None:
    job, signs = tmp_path / "job", tmp_path / "signs"
    for folder in (job, signs):
        folder.mkdir()
    (job / "wait.launch.yaml").write_text(WAITING)
    (job / "wait.py").write_text(WAIT)
    assert server.stdin is not None and server.stdout is not None
    address = server.stdout.readline().strip()
    words = ["-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-nanny"]
    worker = subprocess.Popen(
        [sys.executable, *words, "--no-dashboard", "--local-directory", str(tmp_path / "lost")],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert worker.stderr is not None
    assert any("Registered to" in line for line in worker.stderr)

    sweep = ros_without_router.spawn(
        f"sim sweep wait.launch.yaml --grid wait_for:={signs}/go --output runs "
        f"--cluster {address} --json",
        cwd=job,
    )
    eventually(lambda: list(signs.glob("begun.*")), timeout_s=2 * LONGEST_WAIT_S)
    (begun,) = signs.glob("begun.*")
    assert begun.read_text().startswith(str(tmp_path / "lost")), "it runs beside what was sent"
    server.stdin.write("another worker\n")
    server.stdin.flush()
    worker.kill()
    worker.communicate()
    lost = int(begun.suffix[1:])
    eventually(lambda: _has_ended(lost), timeout_s=LONGEST_WAIT_S)
    (signs / "go").touch()

    assert sweep.wait(2 * LONGEST_WAIT_S) == 0, sweep.stderr
    (run,) = json.loads(sweep.stdout)["runs"]
    assert (run["result"], run["machine"]) == ("done", "under the desk")
    _, again = sorted(signs.glob("begun.*"), key=lambda sign: sign != begun)
    assert again.read_text().startswith(str(tmp_path / "other"))
    assert f"{job} is sent to 1 worker\n" in sweep.stderr
    assert (job / "runs" / "001" / "bag" / "metadata.yaml").is_file(), "bags come back"
    assert run["folder"] == str(job / "runs" / "001")
    assert not list((tmp_path / "other").rglob("sweep-*")), "what was sent is taken away"


def _has_ended(pid: int) -> bool:
    try:
        return psutil.Process(pid).status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def test_paths_below_what_is_sent_are_those_of_the_worker(tmp_path: Path) -> None:
    package = tmp_path / "my_package"
    for inner in ("launch", "worlds", ".git", "runs/001/bag"):
        (package / inner).mkdir(parents=True)
    file = package / "launch" / "go.launch.yaml"
    for each in (file, package / "package.xml", package / "worlds/w.yaml", package / ".git/x"):
        each.write_text("text")
    (package / "runs/sweep.json").touch()
    found, data = pack_launch(file, None, package / "worlds")
    there = tmp_path / "there"
    unpack(data, there)

    names = sorted(str(path.relative_to(there)) for path in there.rglob("*") if path.is_file())
    assert names == ["launch/go.launch.yaml", "package.xml", "worlds/w.yaml"]
    request = RunRequest(
        number=1,
        file=str(file),
        arguments={"world": f"{package}/worlds/w.yaml", "other": f"{package}_2"},
        parameters={},
    )
    moved = found.for_worker(request, there)
    assert moved.file == str(there / "launch/go.launch.yaml")
    assert moved.arguments == {"world": f"{there}/worlds/w.yaml", "other": f"{package}_2"}
    assert found.cwd == "worlds"
    values = ["w.yaml", "1.5", str(tmp_path / "my_package"), os.devnull]
    assert not_sent(values, found, package / "worlds") == [os.devnull]

    built_in, nothing = pack_launch(find_launch_file(None, "sim.yaml"), None, tmp_path)
    assert (built_in.root, nothing) == ("", b"")
    assert Path(built_in.for_worker(request, there).file).name == "sim.yaml"
    with pytest.raises(RefusedError, match="the folder that is sent"):
        pack_launch(file, package / "worlds", tmp_path)


def test_links_are_sent_as_what_they_point_to_but_none_without_end(tmp_path: Path) -> None:
    job, meshes = tmp_path / "job", tmp_path / "meshes"
    for folder in (job, meshes):
        folder.mkdir()
    (job / "go.launch.yaml").write_text("text")
    (meshes / "arm.stl").write_text("mesh")
    (job / "meshes").symlink_to(meshes)
    (job / "one.stl").symlink_to(meshes / "arm.stl")
    (meshes / "back").symlink_to(job)
    _, data = pack_launch(job / "go.launch.yaml", None, job)
    there = tmp_path / "there"
    unpack(data, there)
    names = sorted(str(path.relative_to(there)) for path in there.rglob("*") if path.is_file())
    assert names == ["go.launch.yaml", "meshes/arm.stl", "one.stl"]


def test_what_is_too_large_is_not_sent(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_transfer, "_LARGEST_SENT", 1 << 20)
    (tmp_path / "go.launch.yaml").write_text("text")
    (tmp_path / "large.bin").write_bytes(bytes((1 << 20) + 1))
    with pytest.raises(RefusedError, match="more than 1 MB to be sent") as raised:
        pack_launch(tmp_path / "go.launch.yaml", None, tmp_path)
    assert "--send FOLDER" in (raised.value.hint or "")
