"""Archives from elsewhere (FMU, SSP): looked at before they are unpacked, and what was unpacked
looked at before it is used.
"""

import os
import tempfile
import zipfile
import zlib
from pathlib import Path

from .errors import BadInput

LARGEST_RATIO = 200
"""Unpacked size over packed size that an archive may have; text comes to 30."""
ALWAYS = 2**26
"""Bytes that any archive may come to, whatever its ratio."""
MOST_MEMBERS = 100_000


def check_archive(archive: zipfile.ZipFile, path: Path) -> None:
    """Look at what the archive's directory says; BadInput where it is no archive of this kind.

    The directory binds: a member that holds more than it says is not read beyond that.
    """
    members = archive.infolist()
    unpacked = sum(member.file_size for member in members)
    packed = Path(path).stat().st_size
    if unpacked > max(ALWAYS, LARGEST_RATIO * packed):
        raise BadInput(
            f"{path}: expected at most {LARGEST_RATIO} times the packed {packed / 1e6:.3g} MB, "
            f"got {unpacked / 1e6:.3g} MB"
        )
    if len(members) > MOST_MEMBERS:
        raise BadInput(f"{path}: expected at most {MOST_MEMBERS} files, got {len(members)}")
    for member in members:
        parts = Path(member.filename.replace("\\", "/")).parts
        if ".." in parts or member.filename.startswith("/"):
            raise BadInput(f"{path}: expected files inside it, got path {member.filename!r}")


def heal(path: Path, folder: Path) -> list[str]:
    """Write anew every file of an unpacked archive that is missing or not what it was; their
    names.
    """
    healed = []
    with zipfile.ZipFile(path) as archive:
        for member in archive.infolist():
            target = folder / member.filename
            if member.is_dir() or _is_whole(target, member):
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            handle, fresh = tempfile.mkstemp(dir=target.parent)
            with os.fdopen(handle, "wb") as file:
                file.write(archive.read(member))
            os.chmod(fresh, 0o755)
            os.replace(fresh, target)
            healed.append(member.filename)
    return healed


def _is_whole(target: Path, member: zipfile.ZipInfo) -> bool:
    """Whether a file has the size and the check sum that the archive says."""
    try:
        if target.stat().st_size != member.file_size:
            return False
        return zlib.crc32(target.read_bytes()) == member.CRC
    except OSError:
        return False
