"""Files are written whole, links are followed, and pipes and devices are written as they are."""

from __future__ import annotations

import errno
import os
import shutil
import stat
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi import whole_files
from galvi.whole_files import open_descriptor, write_whole

TEXT = "née\n"


def is_written(path: Path) -> bool:
    return path.read_bytes() == TEXT.encode()


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_a_new_file_has_the_permissions_of_the_umask(tmp_path: Path, mask: int) -> None:
    before = os.umask(mask)
    try:
        write_whole(tmp_path / "a", TEXT)
    finally:
        os.umask(before)
    assert names_in(tmp_path) == ["a"] and is_written(tmp_path / "a")
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o666 & ~mask


@pytest.mark.parametrize("mode", [0o600, 0o755])
@pytest.mark.parametrize("owners", [True, False], ids=["", "as on Windows, without owners"])
def test_a_file_keeps_its_permissions_and_a_reader_its_contents(
    tmp_path, monkeypatch, mode, owners
) -> None:
    if not owners:
        monkeypatch.delattr(os, "chown")
    path = tmp_path / "a"
    path.write_text("old")
    path.chmod(mode)
    with path.open() as reader:
        write_whole(path, TEXT)
        assert reader.read() == "old"
    assert names_in(tmp_path) == ["a"] and is_written(path)
    assert path.stat().st_mode & 0o7777 == mode


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
def test_a_file_keeps_its_owner(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("old")
    os.chown(path, 12, 34)
    write_whole(path, TEXT)
    assert (path.stat().st_uid, path.stat().st_gid) == (12, 34)


@pytest.mark.parametrize("is_there", [True, False], ids=["a file", "nothing"])
def test_a_link_stays_and_what_it_points_to_is_written(tmp_path, is_there) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    if is_there:
        (inner / "a").write_text("old")
        (inner / "a").chmod(0o640)
    (tmp_path / "second").symlink_to("inner/a")
    (tmp_path / "first").symlink_to(tmp_path / "second")
    write_whole(tmp_path / "first", TEXT)
    assert is_written(inner / "a") and names_in(inner) == ["a"]
    assert (tmp_path / "first").is_symlink() and (tmp_path / "second").is_symlink()
    if is_there:
        assert (inner / "a").stat().st_mode & 0o777 == 0o640


def test_links_in_a_circle_are_one_error(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match=r"symbolic links.*a'") as refused:
        write_whole(tmp_path / "a", TEXT)
    assert refused.value.errno == errno.ELOOP and names_in(tmp_path) == ["a", "b"]


@pytest.mark.parametrize("saved", ["text", "a run"])
def test_a_pipe_is_written_and_stays_a_pipe(saved: str, tmp_path: Path) -> None:
    """A run is loaded from the bytes that came out of the pipe."""
    path, received = tmp_path / "pipe", tmp_path / "received"
    os.mkfifo(path)
    reader = threading.Thread(target=lambda: received.write_bytes(path.read_bytes()))
    reader.start()
    if saved == "text":
        write_whole(path, TEXT)
    else:
        method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
        run = galvi.integrate(galvi.problems.kepler(), method, 0.1, 3)
        galvi.save(run, path)
    reader.join(30)
    assert stat.S_ISFIFO(path.stat().st_mode) and names_in(tmp_path) == ["pipe", "received"]
    if saved == "text":
        assert is_written(received)
    else:
        assert np.array_equal(galvi.load(received).q, run.q)


@pytest.fixture
def device(tmp_path: Path) -> Callable[[str], Path]:
    """A function from a name in /dev to the device, or for root, who could replace it, a copy."""

    def device_of(name: str) -> Path:
        path = Path("/dev") / name
        if not path.is_char_device():
            pytest.skip(f"this system has no {path}")
        if os.geteuid() != 0:
            return path
        try:
            os.mknod(tmp_path / name, 0o666 | stat.S_IFCHR, path.stat().st_rdev)
            (tmp_path / name).open("wb").close()
        except OSError:
            pytest.skip("a device cannot be made in a temporary folder")
        return tmp_path / name

    return device_of


def test_a_device_is_written_and_stays_a_device(device, tmp_path: Path) -> None:
    null, full = device("null"), device("full")
    (tmp_path / "link").symlink_to(null)
    before = names_in(tmp_path)
    write_whole(null, TEXT)
    write_whole(tmp_path / "link", TEXT)
    with pytest.raises(OSError, match="No space left"):
        write_whole(full, TEXT)
    assert null.is_char_device() and full.is_char_device()
    assert (tmp_path / "link").is_symlink() and names_in(tmp_path) == before


def test_a_folder_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError, match="a file is expected, and this is a folder: '"):
        write_whole(tmp_path, TEXT)
    assert names_in(tmp_path) == []


@pytest.mark.parametrize("name", ["no/a", "file/a"])
def test_a_folder_that_is_not_there_is_an_error_that_names_the_file(tmp_path, name) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=f"{name}'$"):
        write_whole(tmp_path / name, TEXT)
    assert names_in(tmp_path) == ["file"]


def test_a_write_that_fails_leaves_the_former_file_alone(tmp_path: Path) -> None:
    def write_half(stream) -> None:
        stream.write(b"half")
        raise KeyboardInterrupt

    for path in (tmp_path / "new", tmp_path / "old"):
        (tmp_path / "old").write_text("old")
        with pytest.raises(KeyboardInterrupt):
            write_whole(path, write_half)
        assert names_in(tmp_path) == ["old"] and (tmp_path / "old").read_text() == "old"


@pytest.mark.skipif(not os.path.exists("/dev/fd/1"), reason="this system has no /dev/fd")
@pytest.mark.parametrize("name", ["stdout", "fd/1"])
def test_standard_output_is_written_after_what_was_printed(name: str, capfd: Any) -> None:
    print("before")
    write_whole(f"/dev/{name}", "written\n")
    print("after")
    assert capfd.readouterr().out == "before\nwritten\nafter\n"
    reading, writing = os.pipe()
    write_whole(f"/dev/fd/{writing}", TEXT)
    assert os.read(reading, 100) == TEXT.encode() and stat.S_ISFIFO(os.fstat(writing).st_mode)
    os.close(reading)
    os.close(writing)


PROGRAM = """
import runpy, sys
try:
    runpy.run_path(sys.argv[1])["write_whole"](sys.argv[2], "written")
except OSError as error:
    print(f"{type(error).__name__}: {error}")
"""


def test_a_folder_that_cannot_be_written_is_an_error_that_names_the_file(tmp_path: Path) -> None:
    options = ("--bounding-set=-dac_override", "--inh-caps=-dac_override")
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        pytest.skip("root may write everywhere, and there is no setpriv to prevent it")
    (tmp_path / "old").write_text("old")
    tmp_path.chmod(0o555)
    try:
        prefix = ("setpriv", *options) if os.geteuid() == 0 else ()
        command = [
            *prefix,
            sys.executable,
            "-c",
            PROGRAM,
            whole_files.__file__,
            str(tmp_path / "old"),
        ]
        completed = subprocess.run(command, text=True, capture_output=True, check=True)
    finally:
        tmp_path.chmod(0o755)
    assert (
        completed.stdout == f"PermissionError: [Errno 13] Permission denied: '{tmp_path / 'old'}'\n"
    )
    assert names_in(tmp_path) == ["old"] and (tmp_path / "old").read_text() == "old"


def test_only_this_process_s_descriptors_are_its_open_files(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/dev/fd/2")
    assert open_descriptor(tmp_path / "link") == 2
    assert open_descriptor(f"/proc/{os.getpid()}/fd/7") in (7, None)  # None without /proc
    for path in (tmp_path / "fd" / "1", "1", "-", "/dev/null", f"/proc/{os.getppid()}/fd/1"):
        assert open_descriptor(path) is None
