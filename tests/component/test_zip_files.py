"""Zip files that depend on their members only, and appear complete or not at all."""

import sys
import zipfile
from pathlib import Path

import pytest

from gyro_cosim.component.zip_files import write_zip

MEMBERS = {"a.xml": b"<a/>" * 50, "binaries/linux64/a.so": b"\x7fELF" * 50, "resources/b.fmu": b"PK" * 50}


def test_same_members_give_the_same_bytes_whenever_they_are_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = write_zip(tmp_path / "first.zip", MEMBERS)
    monkeypatch.setattr("time.time", lambda: 2e9)  # another day
    assert write_zip(tmp_path / "second.zip", MEMBERS).read_bytes() == first.read_bytes()


def test_members_keep_their_order_their_right_to_be_executed_and_what_is_stored(tmp_path: Path) -> None:
    file = write_zip(tmp_path / "a.zip", MEMBERS, executable="binaries/", stored=[".fmu"])
    with zipfile.ZipFile(file) as archive:
        rows = [(i.filename, i.external_attr >> 16, i.compress_type) for i in archive.infolist()]
        assert {name: archive.read(name) for name in archive.namelist()} == MEMBERS
    assert rows == [
        ("a.xml", 0o644, zipfile.ZIP_DEFLATED),
        ("binaries/linux64/a.so", 0o755, zipfile.ZIP_DEFLATED),
        ("resources/b.fmu", 0o644, zipfile.ZIP_STORED),
    ]


def test_a_file_that_cannot_be_completed_leaves_the_old_one_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = write_zip(tmp_path / "a.zip", MEMBERS)
    before = file.read_bytes()

    def refuse(self: Path, target: Path) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(Path, "replace", refuse)
    with pytest.raises(OSError, match="no space left"):
        write_zip(file, {"b": b"b"})
    assert file.read_bytes() == before
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.skipif(sys.platform == "win32", reason="permissions of POSIX")
def test_a_new_file_has_the_permissions_that_any_new_file_has(tmp_path: Path) -> None:
    usual = tmp_path / "usual"
    usual.touch()
    assert write_zip(tmp_path / "a.zip", MEMBERS).stat().st_mode == usual.stat().st_mode
