"""A whole run of a system on every platform that this machine can run: the same bytes, or what is missing here.

    python benchmarks/same_bits.py [SYSTEM [STOP]]        lrt-curve, 40 s

The system is packed as one FMU, master and components; its sources are compiled for each platform, by Zig and once by the host's
own compiler, and linked with a program that runs it (same_bits.c). Every output is compared after every 100th macro step, bit by
bit. Takes ten minutes, nearly all of them for compiling the derivatives.
"""

import hashlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import fmpy
import numpy as np
from rich.console import Console
from rich.table import Table

from gyro_cosim import simulate, system
from gyro_cosim.export import pack_fmu
from gyro_cosim.fmus.compiler import FLAGS, host_compiler

STEP, EVERY = 1e-3, 100
ZIG = [sys.executable, "-m", "ziglang", "cc"]
NODE = Path(__file__).with_name("same_bits.mjs")
PLATFORMS = {  # compiler, programs of which one runs what it makes, further options of the program
    "x86_64 Linux, host's compiler": (host_compiler(), (), ()),
    "x86_64 Linux, Zig": ([*ZIG, "-target", "x86_64-linux-musl"], (), ()),
    "aarch64 Linux": ([*ZIG, "-target", "aarch64-linux-musl"], ("qemu-aarch64", "qemu-aarch64-static"), ()),
    "x86_64 Windows": ([*ZIG, "-target", "x86_64-windows-gnu"], ("wine",), ()),
    "WebAssembly": ([*ZIG, "-target", "wasm32-wasi"], ("node",), ("--no-warnings", str(NODE))),
}


def compiled(folder: Path, command: list[str], files: list[str], program: Path) -> Path:
    """The program of the FMU in `folder` and same_bits.c."""
    sources = folder / "sources"
    driver = Path(__file__).with_name("same_bits.c")
    options = ["-O1", *FLAGS, "-I.", "-Wno-psabi", "-w", "-o", str(program), *files, str(driver)]
    done = subprocess.run([*command, *options, "-lm"], cwd=sources, capture_output=True, text=True, check=False)
    if done.returncode:
        raise RuntimeError(done.stderr[-2000:])
    return program


def main() -> None:
    """Pack, compile, run, compare."""
    name, stop = (sys.argv[1:2] or ["lrt-curve"])[0], float((sys.argv[2:3] or ["40"])[0])
    plan = system(name)
    steps = round(stop / STEP)
    table = Table("platform", "run by", "same bits", "sha256", "compile, s", "run, s", box=None)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        (packed,) = pack_fmu(plan, folder, step=STEP)
        with zipfile.ZipFile(packed) as archive:
            archive.extractall(folder / "fmu")
        description = fmpy.read_model_description(str(packed), validate=False)
        outputs = [v for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
        files = re.findall(r'<File name="([^"]+)"', (folder / "fmu" / "modelDescription.xml").read_text(encoding="utf-8"))
        files = list(dict.fromkeys(files))
        arguments = [description.guid, str(steps), str(STEP), str(EVERY), str(len(outputs))]
        arguments += [str(v.valueReference) for v in outputs]
        run = simulate(plan, step=STEP, stop=stop)
        columns = np.array([run.trajectory[v.name] for v in outputs])[:, EVERY::EVERY].T
        wanted = "".join(" ".join(f"{word:016x}" for word in row) + "\n" for row in columns.copy().view(np.uint64)).encode()
        table.add_row(
            "cosim run, in this process's machine",
            "-",
            "-",
            hashlib.sha256(wanted).hexdigest()[:16],
            "-",
            f"{run.timing.loop_s:.1f}",
        )
        for platform, (command, programs, options) in PLATFORMS.items():
            runner = next(filter(None, map(shutil.which, programs)), None)
            if command is None or (programs and runner is None):
                table.add_row(platform, "-", f"not run: needs {' or '.join(programs) or 'a compiler'}", "-", "-", "-")
                continue
            began = time.perf_counter()
            program = compiled(folder / "fmu", command, files, folder / f"program-{len(table.rows)}.exe")
            middle = time.perf_counter()
            whole = [*([runner, *options] if runner else []), str(program), *arguments]
            done = subprocess.run(whole, capture_output=True, check=False)
            if done.returncode:
                table.add_row(platform, runner or "itself", f"failed: {done.stderr.decode()[-200:]}", "-", "-", "-")
                continue
            got = done.stdout.replace(b"\r", b"")
            same = "yes" if got == wanted else f"no, from row {first_difference(got, wanted)}"
            seconds = f"{middle - began:.0f}", f"{time.perf_counter() - middle:.1f}"
            table.add_row(
                platform, Path(runner).name if runner else "itself", same, hashlib.sha256(got).hexdigest()[:16], *seconds
            )
    Console(highlight=False, width=130).print(table)


def first_difference(a: bytes, b: bytes) -> int:
    """Number of the first line that differs, from 1."""
    lines = zip(a.splitlines(), b.splitlines(), strict=False)
    return next((i for i, (x, y) in enumerate(lines, 1) if x != y), min(a.count(b"\n"), b.count(b"\n")) + 1)


if __name__ == "__main__":
    main()
