"""Pictures of a vehicle: what stands where, and how its bodies move in a mode."""

from pathlib import Path

import numpy as np
import pytest

from gyro_cosim.cli import main
from gyro_cosim.figures import Shape, mode_shapes, views
from gyro_cosim.systems import catalogue

LIBRARY = Path(__file__).resolve().parents[2] / "vehicle" / "library"
BOX = {"name": "box", "along": "s", "offset": 1.0, "height": 2.0, "lateral": "y", "vertical": "z", "yaw": "psi", "roll": "phi",
       "pitch": "theta", "shapes": [{"role": "car", "size": [4.0, 2.0, 1.0], "at": [0.0, 0.0, 0.0]}]}  # fmt: skip
SCENE = {"track": {"half_gauge": 0.75}, "bodies": [BOX]}


def moved(**motion: complex) -> list[np.ndarray]:
    """Corners of the box at its largest, from above, from the side, from behind."""
    fig = mode_shapes(SCENE, [Shape("words", motion)], "title")
    found = []
    for ax in fig.axes:
        rest, largest, later = (np.array(line.get_xydata())[:4] for line in ax.get_lines())
        found += [(largest - rest, later - rest)]
    return found


def test_bodies_move_as_their_signals_say() -> None:
    """The largest displacement of a corner is 3.5 % of the length; small rotations turn corners about the centre."""
    above, side, behind = moved(y=1e-4)
    assert above[0] == pytest.approx(np.tile([0.0, 0.14], (4, 1)))
    assert side[0] == pytest.approx(np.zeros((4, 2)))
    assert behind[0] == pytest.approx(np.tile([0.14, 0.0], (4, 1)))
    yawing = moved(psi=1e-3)[0][0]
    assert yawing[:, 1] == pytest.approx([-0.14, 0.14, 0.14, -0.14])
    assert yawing[:, 0] == pytest.approx([0.07, 0.07, -0.07, -0.07])
    pitching = moved(theta=1e-3)[1][0]
    assert pitching[:, 1] == pytest.approx([0.14, -0.14, -0.14, 0.14])  # nose down
    rolling = moved(phi=1e-3)[2][0]
    assert rolling[:, 1] == pytest.approx([-0.14, 0.14, 0.14, -0.14])  # the left side up
    assert moved(s=1e-3)[0][0] == pytest.approx(np.tile([0.14, 0.0], (4, 1)))


def test_what_lags_by_a_quarter_is_drawn_then() -> None:
    above = moved(y=1.0, z=-1j)
    assert above[0][0][:, 1] == pytest.approx(np.full(4, 0.14))
    assert above[0][1] == pytest.approx(np.zeros((4, 2)))
    assert above[1][0] == pytest.approx(np.zeros((4, 2)))
    assert above[1][1][:, 1] == pytest.approx(np.full(4, -0.14))


def test_a_vehicle_is_drawn_with_its_springs_and_its_contact() -> None:
    made = catalogue.component(str(LIBRARY / "lrt.toml"))
    fig = views(made.scene, "title")
    assert [ax.get_xlabel() for ax in fig.axes[:2]] == ["x [m]", "x [m]"]
    joints = [joint for joint in made.scene["joints"] if joint["kind"] == "springs"]
    assert sum(len(joint["lines"]) for joint in joints) == 8  # four corners of two frames
    assert {abs(line[0][1]) for joint in joints for line in joint["lines"]} == {0.7}
    drawn = [line for line in fig.axes[1].get_lines() if line.get_label() == "springs"]
    assert len(drawn) == 8


def test_commands_write_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lrt = str(LIBRARY / "lrt.toml")
    assert main(["vehicle", "check", lrt, "--plot", str(tmp_path / "check.svg")]) == 0
    assert "mount of a gyro unit" in (tmp_path / "check.svg").read_text(encoding="utf-8")
    assert main(["modes", lrt, "--shapes", str(tmp_path / "shapes.svg")]) == 0
    assert "damping ratio" in (tmp_path / "shapes.svg").read_text(encoding="utf-8")
    assert main(["modes", lrt, "--shapes", str(tmp_path / "x.svg"), "--over", "vehicle.speed=5:6:2"]) == 2
    assert "--shapes must be left out with --over" in capsys.readouterr().err
    assert main(["modes", "gyro_unit:linear", "--shapes", str(tmp_path / "y.svg")]) == 2
    assert "--shapes requires a component with a scene of bodies" in capsys.readouterr().err
    assert not (tmp_path / "x.svg").exists()
