"""Work that is done in pieces shows one bar, which never goes back."""

from pathlib import Path

import pytest

from gyro_cosim import paper
from gyro_cosim.master import Progress, stage
from gyro_cosim.paper import vehicle, wheel_pair


def test_a_stage_is_a_share_of_the_whole() -> None:
    seen: list[tuple[float, float]] = []
    piece = stage(lambda done, total: seen.append((done, total)), 0.5, 0.75)
    assert piece is not None
    for done in (0, 1, 4):
        piece(done, 4)
    piece(0, 0)  # nothing to do is all done
    assert seen == [(0.5, 1.0), (0.5625, 1.0), (0.75, 1.0), (0.75, 1.0)]
    assert stage(None, 0.0, 1.0) is None


@pytest.mark.parametrize("full_vehicle", [True, False])
def test_the_papers_bar_runs_once_from_beginning_to_end(
    full_vehicle: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def work(*_: object, progress: Progress, **__: object) -> tuple[list[object], list[Path]]:
        for done in range(1, 4):
            progress(done, 3)
        return [], []

    for module in (wheel_pair, vehicle):
        monkeypatch.setattr(module, "reproduce", work)
    seen: list[float] = []
    paper.reproduce(tmp_path, full_vehicle=full_vehicle, progress=lambda done, total: seen.append(done / total))
    pair = paper.PAIR if full_vehicle else 1.0
    vehicles = [pair + (1.0 - pair) * k / 3 for k in (1, 2, 3)] if full_vehicle else []
    assert seen == pytest.approx([pair / 3, pair * 2 / 3, pair, *vehicles])
