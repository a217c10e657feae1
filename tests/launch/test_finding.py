"""Which file `launch PACKAGE FILE` means."""

import pytest

from teleopctl.errors import NotFoundError
from teleopctl.launch import find_launch_file


@pytest.fixture
def package(tmp_path, monkeypatch):
    folder = tmp_path / "arm"

    def package(*files):
        for file in ("package.xml", *files):
            path = folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text("<package><name>arm</name></package>", encoding="utf-8")
        return folder

    monkeypatch.setenv("TELEOPCTL_PACKAGE_PATH", str(tmp_path))
    return package


def test_a_file_of_a_package_is_found_by_its_name_wherever_it_lies(package):
    folder = package("launch/a.launch.xml", "bringup/sub/b.launch.xml", ".git/b.launch.xml")
    assert find_launch_file("arm", "a.launch.xml") == folder / "launch/a.launch.xml"
    assert find_launch_file("arm", "b.launch.xml") == folder / "bringup/sub/b.launch.xml"
    assert find_launch_file("arm", "bringup/sub/b.launch.xml").is_file()


def test_an_ending_may_be_left_out(package):
    folder = package("launch/a.launch.xml")
    assert find_launch_file("arm", "a") == folder / "launch/a.launch.xml"


def test_a_name_that_two_files_have_is_refused_with_their_places(package):
    folder = package("a/x.launch.xml", "b/x.launch.xml")
    with pytest.raises(NotFoundError) as caught:
        find_launch_file("arm", "x.launch.xml")
    assert caught.value.message == (
        "file 'x.launch.xml' was found more than once in the share directory of package 'arm': "
        f"['{folder}/a/x.launch.xml', '{folder}/b/x.launch.xml']"
    )


def test_what_is_not_there_is_named_with_what_is_spelt_alike(package):
    folder = package("launch/display.launch.xml")
    with pytest.raises(NotFoundError) as caught:
        find_launch_file("arm", "dsplay.launch.xml")
    assert caught.value.message == (
        "file 'dsplay.launch.xml' was not found in the share directory of package 'arm' "
        f"which is at '{folder}'"
    )
    assert "Did you mean display.launch.xml" in str(caught.value.hint)


def test_a_file_of_another_ending_is_no_launch_file(package):
    package("launch/display.toml")
    with pytest.raises(NotFoundError, match=r"display\.toml is not a launch file"):
        find_launch_file("arm", "display.toml")
