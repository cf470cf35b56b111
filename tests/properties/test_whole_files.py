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

import numpy as np
import pytest

import galvi
from galvi.whole_files import open_descriptor, write_whole

HALF = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))


@pytest.fixture(scope="module")
def run() -> galvi.Trajectory:
    return galvi.integrate(galvi.problems.kepler(), HALF, 0.1, 3)


@pytest.fixture(params=["text", "a run"])
def save(request: pytest.FixtureRequest, run: galvi.Trajectory) -> Callable[[Path], None]:
    """Two ways to write a file, by its path."""
    if request.param == "text":
        return lambda path: write_whole(path, "née\n")
    return lambda path: galvi.save(run, path)


def is_written(content: bytes) -> bool:
    """Whether these are the bytes of the text, or of a run: an archive."""
    return content == "née\n".encode() or content[:2] == b"PK"


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_a_new_file_has_the_permissions_of_the_umask(save, tmp_path: Path, mask: int) -> None:
    before = os.umask(mask)
    try:
        save(tmp_path / "a")
    finally:
        os.umask(before)
    assert names(tmp_path) == ["a"] and is_written((tmp_path / "a").read_bytes())
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o666 & ~mask


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o666, 0o755])
def test_a_file_keeps_its_permissions_and_a_reader_its_contents(save, tmp_path, mode) -> None:
    path = tmp_path / "a"
    path.write_text("old")
    path.chmod(mode)
    with path.open() as reader:
        save(path)
        assert reader.read() == "old"
    assert names(tmp_path) == ["a"] and is_written(path.read_bytes())
    assert path.stat().st_mode & 0o7777 == mode


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may give files away")
def test_a_file_keeps_its_owner(save, tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("old")
    os.chown(path, 12, 34)
    save(path)
    assert (path.stat().st_uid, path.stat().st_gid) == (12, 34)


@pytest.mark.parametrize("is_there", [True, False], ids=["a file", "nothing"])
def test_a_link_stays_and_what_it_points_to_is_written(save, tmp_path, is_there) -> None:
    inner = tmp_path / "inner"
    inner.mkdir()
    if is_there:
        (inner / "a").write_text("old")
        (inner / "a").chmod(0o640)
    (tmp_path / "second").symlink_to("inner/a")
    (tmp_path / "first").symlink_to(tmp_path / "second")
    save(tmp_path / "first")
    assert is_written((inner / "a").read_bytes()) and names(inner) == ["a"]
    assert (tmp_path / "first").is_symlink() and (tmp_path / "second").is_symlink()
    if is_there:
        assert (inner / "a").stat().st_mode & 0o777 == 0o640


def test_links_in_a_circle_are_one_error(save, tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OSError, match=r"symbolic links.*a'") as refused:
        save(tmp_path / "a")
    assert refused.value.errno == errno.ELOOP and names(tmp_path) == ["a", "b"]


def test_a_pipe_is_written_and_stays_a_pipe(save, tmp_path: Path) -> None:
    path, received = tmp_path / "pipe", list[bytes]()
    os.mkfifo(path)
    reader = threading.Thread(target=lambda: received.append(path.read_bytes()))
    reader.start()
    save(path)
    reader.join(30)
    assert is_written(received[0])
    assert stat.S_ISFIFO(path.stat().st_mode) and names(tmp_path) == ["pipe"]


@pytest.fixture
def device(tmp_path: Path) -> Callable[[str], Path]:
    """A device by its name in /dev, where root, who might replace it, gets one of its own."""

    def named(name: str) -> Path:
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

    return named


def test_a_device_is_written_and_stays_a_device(save, device, tmp_path: Path) -> None:
    null, full = device("null"), device("full")
    (tmp_path / "link").symlink_to(null)
    before = names(tmp_path)
    save(null)
    save(tmp_path / "link")
    with pytest.raises(OSError, match="No space left"):
        save(full)
    assert null.is_char_device() and full.is_char_device()
    assert (tmp_path / "link").is_symlink() and names(tmp_path) == before


def test_a_folder_is_refused_in_one_sentence(save, tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError, match="a file is expected, and this is a folder: '"):
        save(tmp_path)
    assert names(tmp_path) == []


@pytest.mark.parametrize("name", ["no/a", "file/a"])
def test_a_folder_that_is_not_there_is_an_error_that_names_the_file(save, tmp_path, name) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match=f"{name}'$"):
        save(tmp_path / name)
    assert names(tmp_path) == ["file"]


def test_a_write_that_fails_leaves_the_former_file_alone(tmp_path: Path) -> None:
    def half(stream) -> None:
        stream.write(b"half")
        raise KeyboardInterrupt

    for path in (tmp_path / "new", tmp_path / "old"):
        (tmp_path / "old").write_text("old")
        with pytest.raises(KeyboardInterrupt):
            write_whole(path, half)
        assert names(tmp_path) == ["old"] and (tmp_path / "old").read_text() == "old"


PROGRAM = """
import sys
from galvi.whole_files import write_whole
print("before")
try:
    write_whole(sys.argv[1], "written\\n")
except OSError as error:
    print(f"{type(error).__name__}: {error}", file=sys.stderr)
print("after")
"""


def printed(path: str, *before: str, **more) -> subprocess.CompletedProcess[str]:
    words = [*before, sys.executable, "-c", PROGRAM, path]
    return subprocess.run(words, text=True, stderr=subprocess.PIPE, check=True, **more)


@pytest.mark.skipif(not os.path.exists("/dev/stdout"), reason="this system has no /dev/stdout")
def test_standard_output_is_written_where_it_is_a_pipe_and_where_it_is_a_file(tmp_path) -> None:
    assert printed("/dev/stdout", stdout=subprocess.PIPE).stdout == "before\nwritten\nafter\n"
    path = tmp_path / "a"
    with path.open("w") as stream:
        stream.write("first\n")
        stream.flush()
        printed("/dev/fd/1", stdout=stream)
        stream.write("last\n")
    assert path.read_text() == "first\nbefore\nwritten\nafter\nlast\n" and names(tmp_path) == ["a"]


def test_a_folder_that_cannot_be_written_is_an_error_that_names_the_file(tmp_path: Path) -> None:
    words = ("--bounding-set=-dac_override", "--inh-caps=-dac_override")
    if os.geteuid() == 0 and shutil.which("setpriv") is None:
        pytest.skip("root may write everywhere, and there is no setpriv to prevent it")
    (tmp_path / "old").write_text("old")
    tmp_path.chmod(0o555)
    try:
        before = ("setpriv", *words) if os.geteuid() == 0 else ()
        done = printed(str(tmp_path / "old"), *before, stdout=subprocess.DEVNULL)
    finally:
        tmp_path.chmod(0o755)
    assert done.stderr == f"PermissionError: [Errno 13] Permission denied: '{tmp_path / 'old'}'\n"
    assert names(tmp_path) == ["old"] and (tmp_path / "old").read_text() == "old"


def test_only_this_process_s_descriptors_are_its_open_files(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to("/dev/fd/2")
    assert open_descriptor(tmp_path / "link") == 2
    assert open_descriptor(f"/proc/{os.getpid()}/fd/7") in (7, None)  # None without /proc
    for path in (tmp_path / "fd" / "1", "1", "-", "/dev/null", f"/proc/{os.getppid()}/fd/1"):
        assert open_descriptor(path) is None


def test_a_run_written_to_a_pipe_is_read_from_what_came_out(run, tmp_path: Path) -> None:
    path, received = tmp_path / "pipe", list[bytes]()
    os.mkfifo(path)
    reader = threading.Thread(target=lambda: received.append(path.read_bytes()))
    reader.start()
    galvi.save(run, path)
    reader.join(30)
    (tmp_path / "run.npz").write_bytes(received[0])
    assert np.array_equal(galvi.load(tmp_path / "run.npz").q, run.q)
