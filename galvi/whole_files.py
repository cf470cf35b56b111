"""Writes results: files completely or not at all, and pipes and devices directly."""

from __future__ import annotations

import errno
import os
import re
import stat
import sys
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

Address = str | os.PathLike[str]
Content = str | bytes | Callable[[BinaryIO], object]
MOST_LINKS = 40  # largest number of links that are followed from one path, as in Linux


def write_whole(path: Address, content: Content) -> None:
    """Write a file completely or not at all.

    Parameters
    ----------
    content
        text, which is written as UTF-8, bytes, or a function that writes to a binary stream

    Raises
    ------
    IsADirectoryError
        For a folder.
    OSError
        Where the file cannot be written.

    Notes
    -----
    It is written under another name in the same folder and then renamed, so that a reader finds the
    former contents or the new ones, and nothing is left when that fails. A file keeps its owner and
    its permissions; a new one has those of the umask. Of a symbolic link the file that it points to
    is written, and the link stays. What is neither a file nor a folder, such as a pipe or a device,
    is opened and written, and so is a file that this process has open, where the path names its
    descriptor, as /dev/stdout does.
    """
    descriptor = open_descriptor(path)
    if descriptor is not None:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
        _write_to(os.dup(descriptor), content)
        return
    try:
        former = os.stat(path)
    except FileNotFoundError:  # also of a link to a file that is not there
        former = None
    if former is None or stat.S_ISREG(former.st_mode):
        _replace(Path(os.path.realpath(path)), former, content)
    elif stat.S_ISDIR(former.st_mode):
        raise IsADirectoryError(errno.EISDIR, "a file is expected, and this is a folder", str(path))
    else:
        _write_to(os.open(path, os.O_WRONLY), content)


def open_descriptor(path: Address) -> int | None:
    """The number n where a path leads to /dev/fd/n or /proc/self/fd/n; None for other paths."""
    links = re.compile(rf"/dev/fd|/proc/{os.getpid()}(/task/\d+)?/fd")
    folder, name = os.path.split(path)
    for _ in range(MOST_LINKS):
        folder = os.path.realpath(folder)
        if links.fullmatch(folder) and name.isdecimal():
            return int(name)
        try:
            target = os.readlink(os.path.join(folder, name))
        except OSError:  # no link, or nothing
            return None
        folder, name = os.path.split(os.path.join(folder, target))
    return None


def _replace(path: Path, former: os.stat_result | None, content: Content) -> None:
    """Write a file; ``former`` is its status, None for a new one."""
    partial = path.with_name(f".{uuid.uuid4().hex}.partial")
    mode = 0o666 if former is None else stat.S_IMODE(former.st_mode)
    try:
        descriptor = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from None
    try:
        if former is not None:
            # another user's file stays readable as its mode says; Windows has no owners
            with suppress(OSError, AttributeError):
                os.chown(partial, former.st_uid, former.st_gid)
            os.chmod(partial, mode)
        _write_to(descriptor, content)
        os.replace(partial, path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


def _write_to(descriptor: int, content: Content) -> None:
    """Write to an open file, and close it."""
    with os.fdopen(descriptor, "wb") as stream:
        if callable(content):
            content(stream)
        else:
            stream.write(content.encode() if isinstance(content, str) else content)
