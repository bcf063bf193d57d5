"""One run as a page: what ran, what came out, and the system itself, which runs again in the page.

`contents` gathers what the page shows, `signals` packs the numbers, `module` compiles the system to WebAssembly, `bundling`
builds the page's script, `writing` puts them into one HTML file that loads nothing from anywhere.
"""

from .contents import Told
from .writing import check_format, write_recorded, write_report

__all__ = ["Told", "check_format", "write_recorded", "write_report"]
