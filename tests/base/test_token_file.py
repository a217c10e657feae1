"""Tokens, in files that nobody else can read."""

import os
import sys
import threading
from pathlib import Path

import pytest

from teleopctl.base.files import open_private, write_private
from teleopctl.base.token_file import Address, default_token_file, read_or_make_token, read_token
from teleopctl.errors import InvalidFileError, SystemFailureError

if sys.platform == "win32":
    pytest.skip("files have no modes there", allow_module_level=True)


def write(file, token, mode=0o600):
    file.write_text(token, encoding="utf-8")
    file.chmod(mode)
    return file


def test_a_file_that_is_missing_is_made_with_a_token_that_nobody_guesses(tmp_path):
    token = read_or_make_token(tmp_path / "token")
    assert len(token) >= 32
    assert (tmp_path / "token").stat().st_mode & 0o777 == 0o600
    assert read_or_make_token(tmp_path / "token") == token
    assert [path.name for path in tmp_path.iterdir()] == ["token"]


def test_the_usual_file_is_in_a_folder_of_the_users_own(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    read_or_make_token(default_token_file())
    assert default_token_file().parent.stat().st_mode & 0o777 == 0o700


def test_programs_that_start_at_once_agree(tmp_path, monkeypatch):
    ready = threading.Barrier(8)
    monkeypatch.setattr(os, "getpid", threading.get_ident)
    found = set()

    def read():
        ready.wait()
        found.add(read_or_make_token(tmp_path / "token"))

    threads = [threading.Thread(target=read) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(found) == 1


@pytest.mark.parametrize("token", ["a b", "quo\"te's", "grün ☃", "a" * 4000])
def test_a_token_is_any_line_of_text(tmp_path, token):
    assert read_token(write(tmp_path / "token", f"{token}\n")) == token
    assert read_token(write(tmp_path / "token", f"{token}\r\n")) == token


@pytest.mark.parametrize("text", ["", "\n", " \n", "a\nb\n", "a\x00b", "a" * 5000])
def test_anything_else_is_none(tmp_path, text):
    with pytest.raises(InvalidFileError):
        read_token(write(tmp_path / "token", text))


def test_bytes_that_are_no_text_are_none(tmp_path):
    (tmp_path / "token").touch(0o600)
    (tmp_path / "token").write_bytes(b"\xff\xfe")
    with pytest.raises(InvalidFileError, match="UTF-8"):
        read_token(tmp_path / "token")


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o644])
def test_a_file_that_others_can_read_is_refused(tmp_path, mode):
    with pytest.raises(InvalidFileError, match="Others can read"):
        read_or_make_token(write(tmp_path / "token", "secret", mode))


def test_what_is_no_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe", 0o600)
    for path in (tmp_path / "pipe", tmp_path, tmp_path / "missing" / "token"):
        with pytest.raises((InvalidFileError, SystemFailureError)):
            read_or_make_token(path)


def test_an_address_is_passed_on_without_its_token(tmp_path):
    file = write(tmp_path / "my tökens", "a b&c")
    address = Address("http://robot:8080/", file)
    assert "a b" not in str(address)
    assert Address.parse(str(address)) == address
    assert address.with_token == "http://robot:8080/?token=a%20b%26c"
    file.unlink()
    assert address.with_token == address.url


def test_private_files_are_so_from_the_start_and_from_then_on(tmp_path):
    before = os.umask(0)
    try:
        write_private(tmp_path / "new", "x")
        write(tmp_path / "old", "x", 0o644)
        os.close(open_private(tmp_path / "old", os.O_WRONLY | os.O_APPEND))
    finally:
        os.umask(before)
    for name in ("new", "old"):
        assert (tmp_path / name).stat().st_mode & 0o777 == 0o600
    mode = Path(os.devnull).stat().st_mode
    os.close(open_private(os.devnull, os.O_WRONLY))
    assert Path(os.devnull).stat().st_mode == mode
