"""What somebody else's contender is made of, and a digest that differs when that has changed.

Its process says from where it was imported, as only it knows: finders of editable installs, say,
are at work there. Looked at are the files of all modules that were imported for it, and whole
folders of packages, with their data; not what it imports, or reads, only once it runs.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Collection, Iterable, Iterator
from functools import cache
from importlib import metadata
from pathlib import Path

LARGE = 4 << 20  # bytes above which a file's size and time of change stand for what it holds


def loaded() -> frozenset[str]:
    """Names, without what follows a dot, of the modules that were imported so far."""
    return frozenset(name.partition(".")[0] for name in list(sys.modules))


def places(module: str, before: Collection[str]) -> list[str]:
    """Files and package folders from which modules came that were imported for this one.

    module  the contender's; nothing when it came from no file
    before  what was `loaded` already: the suite and what it stands on
    """
    own = module.partition(".")[0]
    if _file(sys.modules.get(module)) is None:
        return []
    known = {*before, *sys.stdlib_module_names} - {own}
    found: set[Path] = set()
    for name, one in list(sys.modules.items()):
        if name.partition(".")[0] in known:
            continue
        file = _file(one)
        if file is not None:
            found |= {file, *(Path(folder).absolute() for folder in getattr(one, "__path__", ()))}
    return sorted(str(place) for place in found if not found.intersection(place.parents))


def digest(found: Iterable[str]) -> str:
    """Of these files, and of all in these folders but caches, as they are now."""
    whole = hashlib.sha256()
    for path in sorted({path for place in found for path in _files(Path(place))}):
        try:
            state = path.stat()
            content = _content(path, state.st_size, state.st_mtime_ns)
        except OSError as error:  # it went away, or is not ours to read
            content = type(error).__name__.encode()
        whole.update(str(path).encode() + b"\0" + content)
    return whole.hexdigest()


def installed() -> list[str]:
    """Names and versions of all that is installed."""
    return sorted(f"{one.metadata['Name']} {one.version}" for one in metadata.distributions())


def _file(module: object) -> Path | None:
    """From which a module came, be it in an archive; None when there is none."""
    try:
        named = getattr(module, "__file__", None)
    except Exception:  # some modules are objects that only look like one
        return None
    if not isinstance(named, str):
        return None
    path = Path(named).absolute()
    return next((place for place in (path, *path.parents) if place.is_file()), None)


def _files(place: Path) -> Iterator[Path]:
    if not place.is_dir():
        yield place
        return
    for folder, inner, names in os.walk(place):
        inner[:] = [name for name in inner if name != "__pycache__" and not name.startswith(".")]
        yield from (Path(folder, name) for name in names)


@cache
def _content(path: Path, size: int, changed: int) -> bytes:
    """A digest of what the file held when it had this size and this time of its last change, in ns;
    of a large one, of these. OSError when it cannot be read.
    """
    if size > LARGE:
        return f"{size} {changed}".encode()
    return hashlib.sha256(path.read_bytes()).digest()
