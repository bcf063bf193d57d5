"""What a loss of power can leave, on a disk that forgets; and a short part of the campaign, which must see what is forgotten."""

import subprocess
import sys
from pathlib import Path

import pytest
from lossy_disk import Call, Disk, cuts

CAMPAIGN = Path(__file__).parents[2] / "campaigns" / "powerloss.py"


def calls(*told: tuple[str, str, str, int, int, bytes]) -> list[Call]:
    return [Call(*one) for one in told]


REPLACED = calls(
    ("C", "b", "", 7, 0, b""), ("W", "b", "", 7, 0, b"new"), ("S", "b", "", 7, 0, b""), ("R", "b", "a", 0, 0, b""),
    ("S", ".", "", 1, 0, b""),
)  # fmt: skip


def states(folder: Path, done: list[Call]) -> list[tuple[int, dict[str, bytes]]]:
    """Every state that can be found: (call before which the power went, files)."""
    (folder / "a").write_bytes(b"old")
    return [(k, state) for k, _, state in cuts(Disk(folder), done, 20)]


def test_a_file_that_is_replaced_as_it_should_be_is_old_or_new_at_any_time(tmp_path: Path) -> None:
    found = states(tmp_path, REPLACED)
    assert {state["a"] for _, state in found} == {b"old", b"new"}
    assert [state for k, state in found if k == len(REPLACED)] == [{"a": b"new"}]
    assert {b"", b"new", b"\0\0\0"} == {state["b"] for _, state in found if "b" in state}


@pytest.mark.parametrize(("without", "seen"), [(2, {b"", b"\0\0\0"}), (4, {b"old"})])
def test_what_is_not_forced_to_the_disk_can_be_lost(without: int, seen: set[bytes], tmp_path: Path) -> None:
    """Without the file's fsync its name can be there before its data; without the folder's the old one can come back."""
    short = REPLACED[:without] + REPLACED[without + 1 :]
    at_the_end = {state.get("a", b"gone") for k, state in states(tmp_path, short) if k == len(short)}
    assert at_the_end == {*seen, b"new"}


def test_data_survives_by_sectors_and_an_inode_is_given_again(tmp_path: Path) -> None:
    done = calls(
        ("C", "b", "", 7, 0, b""), ("S", ".", "", 1, 0, b""), ("W", "b", "", 7, 0, b"x" * 1024), ("U", "b", "", 0, 0, b""),
        ("C", "c", "", 7, 0, b""), ("W", "c", "", 7, 0, b"y"),
    )  # fmt: skip
    kept = {state.get("b", b"gone") for _, state in states(tmp_path, done)}
    first, second = (b"x" * 512).ljust(1024, b"\0"), b"\0" * 512 + b"x" * 512
    assert {b"", b"gone", b"x" * 512, first, second, b"x" * 1024, b"\0" * 1024} == kept


@pytest.mark.skipif(sys.platform != "linux", reason="the recorder is preloaded as Linux does it")
@pytest.mark.parametrize(("forget", "code"), [((), 0), (("--forget", "files"), 1)])
def test_resumed_after_a_loss_of_power_a_run_gives_the_same_bytes(forget: tuple[str, ...], code: int) -> None:
    """At length: campaigns/powerloss.py."""
    command = [sys.executable, str(CAMPAIGN), "--most", "10", *forget, "two folders"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == code, done.stdout + done.stderr
    assert "10 states: " in done.stdout
    assert ("torn" in done.stdout) == bool(forget)
