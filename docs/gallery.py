"""Make the pictures of the README and of the pages anew: run the command that draws each, and put it into docs/images.

    python docs/gallery.py [IMAGE ...]      all of them (half an hour on two cores), or those named, such as wheel-pair

A figure that is there already, in results/, is not drawn again: remove results/ to have everything anew. The two of
docs/claims.md come from a longer study, which that page names.
"""

import shlex
import subprocess
import sys
from pathlib import Path

from PIL import Image

ROOT = Path(__file__).parent.parent
WIDTH = 1400  # pixels, at most
PAIR = "cosim run wheel-pair --set gyro.rotor_speed=200rpm --stop 40 --plot results/gallery/wheel-pair.png"
RIG = ("cosim compare wheel-pair --gyro nonlinear --gyro hil,rate_delay=20ms,moment_delay=20ms --set gyro.rotor_speed=400rpm "
       "--stop 10 --in-process --plot results/gallery/rig.png")  # fmt: skip
DELAY = ("cosim delay wheel-pair --set gyro.rotor_speed=200rpm --step 50ms --longest 200ms "
         "--map gyro.rotor_speed=100rpm:600rpm:6 --plot results/gallery/delay.png")  # fmt: skip
CHECK = "cosim vehicle check vehicle/library/manchester_1.toml --plot results/gallery/vehicle-check.png"
CYCLES = "cosim limit-cycles vehicle:wheelset --over vehicle.speed=10:60:6 --plot results/gallery/limit-cycles.png"
SHAPES = "cosim modes lrt-straight --set vehicle.speed=10 --shapes results/gallery/mode-shapes.png"
STUDIES = ("comfort", "critical_speed", "decision", "derailment_map", "gimbal_design", "gyro_cost", "lean_units", "optimum",
           "rivals", "root_locus", "safe_speed", "solid_axle", "stability_law", "stability_map")  # fmt: skip

# image -> the command that draws it, the file that this makes
PICTURES = {
    "lrt-curve": ("make run", "results/lrt-curve.png"),
    "wheel-pair": (PAIR, "results/gallery/wheel-pair.png"),
    "convergence": ("cosim converge wheel-pair --plot results/gallery/convergence.png", "results/gallery/convergence.png"),
    "figure_7": ("cosim paper", "results/paper/figure_7.png"),
    "rig": (RIG, "results/gallery/rig.png"),
    "report": ("python docs/report_picture.py", "results/gallery/report.png"),
    "vehicle-check": (CHECK, "results/gallery/vehicle-check.png"),
    "limit-cycles": (CYCLES, "results/gallery/limit-cycles.png"),
    "mode-shapes": (SHAPES, "results/gallery/mode-shapes.png"),
    "delay": (DELAY, "results/gallery/delay.png"),
    **{f"study-{s.replace('_', '-')}": (f"python studies/{s}.py", f"results/studies/{s}.png") for s in STUDIES},
}

wanted = sys.argv[1:] or list(PICTURES)
for name in wanted:
    if name not in PICTURES:
        sys.exit(f"image must be one of {', '.join(PICTURES)}, got {name!r}")
for name in wanted:
    command, made = PICTURES[name]
    if not (ROOT / made).is_file():
        (ROOT / made).parent.mkdir(parents=True, exist_ok=True)
        print(command, flush=True)
        words = shlex.split(command)
        words = {"cosim": [sys.executable, "-m", "gyro_cosim"], "python": [sys.executable]}.get(words[0], words[:1]) + words[1:]
        subprocess.run(words, cwd=ROOT, stdout=subprocess.DEVNULL, check=False)  # compare's verdict is an exit code, too
    if not (ROOT / made).is_file():
        sys.exit(f"{command} must write {made}, it did not")
    with Image.open(ROOT / made) as drawn:
        picture = drawn.convert("RGB")
        picture.thumbnail((WIDTH, 4 * WIDTH), Image.Resampling.LANCZOS)
        picture.save(ROOT / "docs" / "images" / f"{name}.png", optimize=True)
    print(f"wrote docs/images/{name}.png")
