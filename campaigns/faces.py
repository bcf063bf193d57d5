"""Our C code under sanitizers: every entry of both faces of our FMUs, in any order, with any numbers.

    python campaigns/faces.py [--sequences N] [--seed K] [COMPONENT ...]      `make fuzz`

The C files of an FMU are compiled together with c/faces.c by gcc or clang, once with AddressSanitizer and
UndefinedBehaviorSanitizer, once with ThreadSanitizer, where instances run in two threads. Sequences of up to 400 calls come from
a generator; with `clang -DLIBFUZZER -fsanitize=fuzzer` the same file is a target of libFuzzer. Exit code 1 if anything is found.
"""

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

from gyro_cosim.systems import catalogue

DRIVER = Path(__file__).parent / "c" / "faces.c"
FLAGS = ["-std=c99", "-D_DEFAULT_SOURCE", "-g", "-O1", "-ffp-contract=off", "-fno-sanitize-recover=all"]
WATCHED = {
    "address,undefined": (["-fsanitize=address,undefined,float-cast-overflow"], 1),
    "thread": (["-fsanitize=thread"], 2),
}
COMPONENTS = ("gyro_unit:hil", "gyro_unit:scheduled", "gyro_unit:multibody", "vehicle:wheel_pair")
LONGEST = 600  # s


def compiled(spec: str, folder: Path, flags: list[str]) -> Path:
    """The driver with the C files of a component."""
    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        raise FileNotFoundError("gcc or clang must be on the machine: sanitizers come with them")
    with zipfile.ZipFile(catalogue.fmu(spec)) as archive:
        for name in archive.namelist():
            if name.startswith("sources/"):
                archive.extract(name, folder)
    sources = folder / "sources"
    data = (sources / "model_data.h").read_text(encoding="utf-8")
    token, continuous = re.search(r'TOKEN "([^"]+)"', data), re.search(r"N_CONTINUOUS (\d+)", data)
    assert token is not None  # every component has both
    assert continuous is not None
    files = [str(DRIVER), "fmu.c", "equations.c", "rhs_derivatives.c", "output_derivatives.c"]
    macros = [f'-DTOKEN="{token[1]}"', f"-DN_CONTINUOUS={continuous[1]}"]
    program = folder / "faces"
    command = [compiler, *FLAGS, *flags, "-I.", *macros, "-o", str(program), *files, "-lm", "-lpthread"]
    subprocess.run(command, cwd=sources, check=True)
    return program


def found(program: Path, seed: int, sequences: int, threads: int) -> str:
    """What a sanitizer says, in a line; empty where it says nothing."""
    call = [str(program), str(seed), str(sequences), str(threads)]
    try:
        done = subprocess.run(call, capture_output=True, text=True, errors="replace", timeout=LONGEST, check=False)
    except subprocess.TimeoutExpired:
        return f"no end within {LONGEST} s"
    if done.returncode == 0:
        return ""
    lines = [line for line in done.stderr.splitlines() if "ERROR" in line or "runtime error" in line or "WARNING" in line]
    return (lines or done.stderr.splitlines() or [f"exit code {done.returncode}"])[0].strip()


def main() -> int:
    """Exit code 1 where there are findings."""
    parser = argparse.ArgumentParser(description="our C code under sanitizers")
    parser.add_argument("components", nargs="*", default=COMPONENTS)
    parser.add_argument("--sequences", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    wrong = 0
    for spec in chosen.components:
        for watched, (flags, threads) in WATCHED.items():
            with tempfile.TemporaryDirectory() as scratch:
                program = compiled(spec, Path(scratch), flags)
                began = time.perf_counter()
                said = found(program, chosen.seed, chosen.sequences, threads)
                wrong += said != ""
                took = time.perf_counter() - began
                how_many = f"{threads * chosen.sequences} sequences, {took:.0f} s"
                print(f"{spec:<22} {watched:<18} {how_many}: {said or 'nothing'}", flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
