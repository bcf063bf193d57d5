"""The FMUs on other platforms, and under sanitizers: run where an emulator is installed (qemu-user, wine)."""

import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmu_models import COMPONENTS

from gyro_cosim import fmus
from gyro_cosim.fmus.compiler import PLATFORMS
from gyro_cosim.fmus.package import header_folder
from gyro_cosim.systems import catalogue

pytestmark = pytest.mark.slow
SUPPORT = Path(__file__).parents[1] / "support"
SYSROOT = Path("/usr/aarch64-linux-gnu")  # Debian's libc6-arm64-cross


def run(path: Path, folder: Path, library: Path, driver: list[str], env: dict[str, str] | None = None) -> np.ndarray:
    """The driver's table of outputs, shape (50, n_y)."""
    description = fmpy.read_model_description(str(path), validate=False)
    references = {c: [str(v.valueReference) for v in description.modelVariables if v.causality == c] for c in ("input", "output")}
    counts = [str(len(references[c])) for c in ("input", "output")]
    done = subprocess.run(
        [*driver, str(library), description.guid, *counts, *references["input"], *references["output"]],
        capture_output=True, text=True, env=env, check=False, cwd=folder,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])


def build_driver(folder: Path, target: str, suffix: str = "") -> Path:
    program = folder / f"driver{suffix}"
    command = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[target].target, "-O1", f"-I{header_folder()}"]
    subprocess.run([*command, "-o", program, SUPPORT / "fmu_driver.c"], check=True)
    return program


@pytest.mark.parametrize("name", ["gyro_unit:nonlinear", "vehicle:wheel_pair", "vehicle:lrt", "radau", "rosenbrock", "sampled"])
@pytest.mark.parametrize("target", ["aarch64-linux", "x86_64-windows"])
def test_platforms_give_the_same_bits(name: str, target: str, tmp_path: Path) -> None:
    """The operations are the same, and those of our mathematics are part of them."""
    programs = ("qemu-aarch64-static", "qemu-aarch64") if target == "aarch64-linux" else ("wine",)
    emulator = next(filter(None, map(shutil.which, programs)), None)
    if emulator is None or (target == "aarch64-linux" and not SYSROOT.is_dir()):
        pytest.skip(f"no emulator for {target}")
    (path,) = fmus.export(
        COMPONENTS[name]() if name in COMPONENTS else catalogue.component(name), tmp_path, platforms=("x86_64-linux", target)
    )
    folder = tmp_path / "fmu"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    results = []
    for platform in ("x86_64-linux", target):
        p = PLATFORMS[platform]
        (library,) = (folder / "binaries" / p.folder).iterdir()
        driver = [str(build_driver(tmp_path, platform, f"-{platform}{'.exe' if p.suffix == '.dll' else ''}"))]
        if platform == "aarch64-linux":
            driver = [emulator, "-L", str(SYSROOT), *driver]
        elif platform == "x86_64-windows":
            driver = [emulator, *driver]
        env = {**os.environ, "WINEPREFIX": str(tmp_path / "wine"), "WINEDEBUG": "-all", "HOME": str(tmp_path)}
        results.append(run(path, folder, library, driver, env))
    assert results[0].size > 0
    assert results[0].tobytes() == results[1].tobytes()


@pytest.mark.parametrize("name", COMPONENTS)
def test_sanitizers_find_nothing(built: Callable, name: str, tmp_path: Path) -> None:
    """AddressSanitizer (with leaks) and UndefinedBehaviorSanitizer over steps, saved states and derivatives."""
    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no compiler with sanitizers")
    c, path, _ = built(name)
    folder = tmp_path / "fmu"
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    flags = ["-std=c99", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", f"-I{folder / 'sources'}"]
    files = ["fmu.c", "rhs_derivatives.c", "output_derivatives.c"]
    library = tmp_path / "library.so"
    subprocess.run([compiler, *flags, "-shared", "-fPIC", "-o", library, *files, "-lm"], cwd=folder / "sources", check=True)
    driver = tmp_path / "driver"
    subprocess.run([compiler, *flags, "-o", driver, SUPPORT / "fmu_driver.c", "-ldl"], check=True)
    assert run(path, folder, library, [str(driver)]).shape == (50, len(c.outputs))
