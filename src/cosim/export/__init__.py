"""A coupled system as one FMU: the inner loop, the components and their wiring in one library per platform.

    pack_fmu(system, "built")        # built/wheel-pair.fmu

From system to file: components (what each is, and whether the kernel can run it), variables (what the FMU shows), tables
(system_data.h for the C code in c/), description (modelDescription.xml), package (the zip file). The compiler is that of the
installed exporter.
"""

from .package import pack_fmu

__all__ = ["pack_fmu"]
