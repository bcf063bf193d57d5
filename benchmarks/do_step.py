"""How long the FMUs' doStep takes through C, and how long an export takes. Run: python benchmarks/do_step.py

Every figure stands beside a bare loop over the generated step function, compiled alike, in the same run: the ratio counts.
"""

import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path
from pkgutil import resolve_name
from xml.etree import ElementTree

from gyro_cosim import fmus
from gyro_cosim.component import Component
from gyro_cosim.fmus.compiler import FLAGS, host, host_compiler
from gyro_cosim.fmus.package import header_folder

STEPS = 1_000_000
BARE = """
#include <stdio.h>
#include <string.h>
#include <time.h>
#include "model.c"
#include "model_data.h"
int main(void) {
    static double x[N_X + 1], U[3 * N_U + 3], p[N_P + 1], tau = 0, h = %r, next[N_X + 1], w[WORK_REALS];
    static int iw[WORK_INTEGERS];
    const double *arg[WORK_ARGUMENTS] = {x, U, p, &tau, &h};
    double *res[WORK_RESULTS] = {next};
    memcpy(x, START_X, N_X * sizeof(double)); memcpy(p, START_P, N_P * sizeof(double)); U[0] = 0.1;
    clock_t start = clock();
    for (long i = 0; i < %d; i++) { MODEL(step)(arg, res, iw, w, 0); memcpy(x, next, N_X * sizeof(double)); }
    printf("%%.4g %%g", (double)(clock() - start) / CLOCKS_PER_SEC / %d, x[0]);
}
"""


def measure(component: Component, folder: Path, steps: int) -> dict[str, float]:
    """Seconds per call, by what is called."""
    began = time.perf_counter()
    (path,) = fmus.export(component, folder)
    found = {"export": time.perf_counter() - began}
    unpacked = folder / "fmu"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(unpacked)
    root = ElementTree.parse(unpacked / "modelDescription.xml").getroot()
    reference = next(v.get("valueReference") for v in root.iter("ScalarVariable") if v.get("causality") == "input")
    compiler = host_compiler() or [sys.executable, "-m", "ziglang", "cc", "-target", host().target]
    include = [f"-I{header_folder()}", f"-I{unpacked / 'sources'}"]
    driver = folder / "do_step"
    subprocess.run([*compiler, "-O2", *include, "-o", driver, Path(__file__).with_suffix(".c"), "-ldl"], check=True)
    (library,) = unpacked.glob("binaries/*/*")
    arguments = [str(library), root.get("guid"), reference, repr(component.internal_step), str(steps)]
    alone, whole, rollback, _, _ = subprocess.run([driver, *arguments], capture_output=True, text=True, check=True).stdout.split()
    found |= {"doStep": float(alone), "set, doStep, get": float(whole), "save and restore": float(rollback)}
    (folder / "bare.c").write_text(
        "#define CORE_H\n#include <stdint.h>\n"
        + BARE.replace('#include "model_data.h"', "") % (component.internal_step, steps, steps)
    )
    text = (folder / "bare.c").read_text().replace('#include "model.c"', '#include "model_data.h"\n#include "model.c"')
    (folder / "bare.c").write_text(text)
    subprocess.run([*compiler, "-O3", *FLAGS, *include, "-o", folder / "bare", folder / "bare.c", "-lm"], check=True)
    found["bare step"] = float(subprocess.run([folder / "bare"], capture_output=True, text=True, check=True).stdout.split()[0])
    return found


def main() -> None:
    """Print a table for the small gyro, the wheel pair and the full vehicle."""
    cases = [
        ("gyro_cosim.gyro_unit.nonlinear:nonlinear_small", STEPS),
        ("gyro_cosim.vehicle.wheel_pair:small_wheel_pair", STEPS),
        *sys.argv[1:2],
    ]
    for case in cases:
        spec, steps = case if isinstance(case, tuple) else (case, STEPS // 100)
        with tempfile.TemporaryDirectory() as folder:
            found = measure(resolve_name(spec)(), Path(folder), steps)
        print(f"{spec}: export {found.pop('export'):.2f} s")
        for what, seconds in found.items():
            print(f"  {what:18} {seconds * 1e6:8.3f} us  {seconds / found['bare step']:6.2f} x bare step")


if __name__ == "__main__":
    main()
