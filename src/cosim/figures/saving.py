"""Figures in files: whole or not there, the same bytes for the same figure, and marked as ours.

The mark is what tells a figure that may be drawn again from a file that somebody else made.
"""

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gyro_cosim.component.whole_files import whole_file

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARK = "gyro-cosim"
METADATA: dict[str, dict[str, Any]] = {  # without dates: the same figure is the same file
    ".png": {"Software": MARK},
    ".pdf": {"Creator": MARK, "CreationDate": None},
    ".svg": {"Creator": MARK, "Date": None},
    ".eps": {"Creator": MARK},
    ".ps": {"Creator": MARK},
}
ABOUT = {".png": "Description", ".pdf": "Subject", ".svg": "Description"}  # where a format has room for more words
RESOLUTION = 150  # dots per inch of a picture in pixels, where its style says nothing
SETTINGS = {  # fonts inside as TrueType, text of an .svg as text, names in it that do not change
    "pdf.fonttype": 42,
    "ps.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": MARK,
}


def save(fig: "Figure", file: str | Path, about: str = "") -> Path:
    """Write a figure in the format that the file's ending names.

    Parameters
    ----------
    fig
        The figure.
    file
        Where to; its folder is made.
    about
        What a .png, .pdf or .svg tells besides: the command that drew it, versions.

    Returns
    -------
    Path
        Of the file.
    """
    from matplotlib import rc_context, rcParams

    file = Path(file)
    file.parent.mkdir(parents=True, exist_ok=True)
    kind = file.suffix.lower()
    words = METADATA.get(kind)
    if words is not None and about and kind in ABOUT:
        words = {**words, ABOUT[kind]: about}
    resolution = rcParams["savefig.dpi"]
    with whole_file(file) as beside, rc_context(SETTINGS):
        fig.savefig(beside, dpi=RESOLUTION if resolution == "figure" else resolution, metadata=words)
    return file


def check_format(file: Path) -> None:
    """Refuse a file name whose ending is no format matplotlib writes."""
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if file.suffix.removeprefix(".").lower() not in known:
        raise ValueError(f"plot file must end in one of {', '.join(sorted('.' + k for k in known))}, got {str(file)!r}")


def made_here(file: Path) -> bool:
    """Whether a figure in a file carries the mark that save() gives it: a .png, .pdf, .svg, .eps or .ps."""
    kind = file.suffix.lower()
    if kind == ".png":
        return _software(file) == MARK
    content = file.read_bytes() if kind in METADATA else b""
    mark = MARK.encode()
    if kind == ".pdf":  # by the trailer: a paper that includes a figure of ours holds its creator as well
        about = re.findall(rb"/Info (\d+) 0 R", content[-1024:])
        told = re.search(rb"\n" + about[-1] + rb" 0 obj\s*<<.*?>>", content, re.DOTALL) if about else None
        return told is not None and b"/Creator (" + mark + b")" in told[0]
    if kind == ".svg":  # another editor keeps the creator and adds names of its own
        return b"<dc:title>" + mark + b"</dc:title>" in content[:4096] and b"inkscape" not in content[:4096]
    return b"%%Creator: " + mark in content[:1024]


def _software(file: Path) -> str:
    """What made a .png, as its text says; empty where it does not, and where it is no .png."""
    from PIL import Image

    try:
        with Image.open(file, formats=("PNG",)) as picture:
            return str(picture.info.get("Software", ""))
    except (OSError, ValueError, SyntaxError):
        return ""
