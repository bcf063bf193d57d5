"""Runs every study, two at a time, since each has stretches that keep one core only. What was stopped goes on.

python studies [--short]        what the scripts print, and how long each took; exit code 1 if one of them fails
"""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

HERE = Path(__file__).parent
LONGEST = (
    "decision",
    "derailment_map",
    "comfort",
    "rivals",
    "safe_speed",
    "lean_units",
    "gimbal_design",
)  # begun first, so that none is left over at the end


def run(script: Path) -> tuple[Path, int, str, float]:
    """A script with its exit code, what it printed and its seconds."""
    began = time.perf_counter()
    done = subprocess.run([sys.executable, script, *sys.argv[1:]], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return script, done.returncode, done.stdout, time.perf_counter() - began


if __name__ == "__main__":
    others = sorted(script.stem for script in HERE.glob("[!_]*.py"))
    names = [*LONGEST, *(name for name in others if name not in LONGEST)]
    began, failed = time.perf_counter(), []
    with ThreadPoolExecutor(2) as pool:
        for job in as_completed([pool.submit(run, HERE / f"{name}.py") for name in names]):
            script, code, words, seconds = job.result()
            print(f"== {script.stem}\n{words}== {script.stem}: {seconds:.0f} s, exit code {code}\n", flush=True)
            failed += [script.stem] * (code != 0)
    print(
        f"{len(names)} studies in {(time.perf_counter() - began) / 60:.1f} min" + f"; failed: {', '.join(failed)}" * bool(failed)
    )
    sys.exit(bool(failed))
