"""Put the results of a study of draws into docs/claims.md: its tables between the marks, its figures into docs/images.

cosim paper --draws 300 --seed 1 -o results/claims
python benchmarks/claims_page.py results/claims
"""

import shutil
import sys
from pathlib import Path

BEGIN, END = "<!-- from here on as benchmarks/claims_page.py put it -->\n", "<!-- to here -->\n"
LARGEST = 200_000  # bytes of a figure

results = Path(sys.argv[1])
docs = Path(__file__).parent.parent / "docs"
page = docs / "claims.md"
before, begin, rest = page.read_text(encoding="utf-8").partition(BEGIN)
_, end, after = rest.partition(END)
if not (begin and end):
    sys.exit(f"{page} must have the marks {BEGIN.strip()!r} and {END.strip()!r}")
study = (results / "sensitivity.md").read_text(encoding="utf-8").partition("\n\n")[2]
page.write_text(f"{before}{BEGIN}\n{study}\n{END}{after}", encoding="utf-8")
for figure in ("claims_shares.png", "claims_correlations.png"):
    size = (results / figure).stat().st_size
    if size > LARGEST:
        sys.exit(f"{figure} must be at most {LARGEST} bytes, is {size}")
    shutil.copyfile(results / figure, docs / "images" / figure)
print(f"wrote {page} and its figures")
