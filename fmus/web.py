"""WebAssembly for the report's page: what is compiled besides an FMU's sources, and what is left out.

There is no C library there; web/libc.c has the little that is needed. Derivatives are most of the code and of the time that
compiling takes, and a run needs none of them: their functions refuse.
"""

import importlib.util
import re
from collections.abc import Mapping
from pathlib import Path

__all__ = ["headers", "sources"]

LIBRARY = Path(__file__).parent / "web" / "libc.c"
_DERIVATIVES = "_derivatives.c"
_FUNCTION = re.compile(
    r"^int (\w+)\(const real \*\*arg, real \*\*res, int \*integers, real \*work, int memory\) \{", re.MULTILINE
)


def headers() -> list[str]:
    """Options for Zig's compiler: its headers of a C library, without the library, which takes a minute to build."""
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError("WebAssembly needs Zig's C compiler: python -m pip install ziglang", name="ziglang")
    folder = Path(spec.origin).parent / "lib" / "libc" / "include"
    return ["-nostdlib", *(f"-isystem{folder / kind}" for kind in ("wasm-wasi-musl", "generic-musl"))]


def sources(folder: Path, levels: Mapping[str, str]) -> dict[str, str]:
    """Optimization by C file for WebAssembly; the files that others stand for are written into `folder`.

    Parameters
    ----------
    folder : Path
        Holds the C files.
    levels : mapping of str to str
        Optimization by C file for any other platform.
    """
    (folder / LIBRARY.name).write_bytes(LIBRARY.read_bytes())
    compiled = {LIBRARY.name: "-O2"}
    for file, level in levels.items():
        if not file.endswith(_DERIVATIVES):
            compiled[file] = level
            continue
        names = _FUNCTION.findall((folder / file).read_text(encoding="utf-8"))
        refusing = f"{file.removesuffix('.c')}_refused.c"
        lines = [f"int {name}(const double **a, double **r, int *i, double *w, int m) {{ return 1; }}" for name in names]
        (folder / refusing).write_text("\n".join(["/* No derivatives here. */", *lines, ""]), encoding="utf-8")
        compiled[refusing] = "-O1"
    return compiled
