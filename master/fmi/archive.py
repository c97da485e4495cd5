"""Checks of archives (FMU, SSP) before and after they are unpacked into the cache."""

import os
import shutil
import tempfile
import warnings
import zipfile
import zlib
from hashlib import sha256
from pathlib import Path

from .cache import cache_folder
from .errors import BadInput

LARGEST_RATIO = 200
"""Largest allowed ratio of unpacked to packed size. Text reaches about 30."""
ALLOWED_SIZE = 2**26
"""Unpacked size that is allowed at any ratio [bytes]."""
MOST_MEMBERS = 100_000


def check_archive(archive: zipfile.ZipFile, path: Path, key: str = "") -> None:
    """Check the directory of an archive before it is unpacked; raise `BadInput` with its fault.

    Reading a member stops at the size that the directory states.
    """
    members = archive.infolist()
    unpacked = sum(member.file_size for member in members)
    packed = Path(path).stat().st_size
    if unpacked > max(ALLOWED_SIZE, LARGEST_RATIO * packed):
        raise BadInput(
            f"{key}{path}: expected at most {LARGEST_RATIO} times the packed {packed / 1e6:.3g} "
            f"MB, got {unpacked / 1e6:.3g} MB"
        )
    if len(members) > MOST_MEMBERS:
        raise BadInput(f"{key}{path}: expected at most {MOST_MEMBERS} files, got {len(members)}")
    for member in members:
        parts = Path(member.filename.replace("\\", "/")).parts
        if ".." in parts or member.filename.startswith("/"):
            raise BadInput(f"{key}{path}: expected files inside it, got path {member.filename!r}")


def unpack(path: Path) -> Path:
    """Unpack an FMU into a folder of the user's cache, named by its hash; return the folder."""
    digest = sha256(Path(path).read_bytes()).hexdigest()[:16]
    folder = cache_folder("unpacked") / f"{Path(path).stem}-{digest}"
    if folder.exists():
        if restored := restore_files(path, folder):
            warnings.warn(f"{folder}: was damaged; restored {', '.join(restored)}", stacklevel=2)
    else:
        partial = Path(tempfile.mkdtemp(dir=folder.parent))
        with zipfile.ZipFile(path) as archive:
            check_archive(archive, Path(path))
            archive.extractall(partial)
        try:
            partial.rename(folder)
        except OSError:  # another process was faster
            shutil.rmtree(partial)
    return folder


def restore_files(path: Path, folder: Path) -> list[str]:
    """Restore the files of an unpacked archive that are missing or changed; return their names."""
    restored: list[str] = []
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            target = folder / member.filename
            if member.is_dir() or _is_intact(target, member):
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, temporary = tempfile.mkstemp(dir=target.parent)
            with os.fdopen(handle, "wb") as file:
                file.write(archive.read(member))
            os.chmod(temporary, 0o755)
            os.replace(temporary, target)
            restored.append(member.filename)
    return restored


def _is_intact(target: Path, member: zipfile.ZipInfo) -> bool:
    """Return whether a file has the size and the checksum of the archive's member."""
    try:
        if target.stat().st_size != member.file_size:
            return False
        return zlib.crc32(target.read_bytes()) == member.CRC
    except OSError:
        return False
