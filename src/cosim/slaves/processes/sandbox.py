"""What the process of an isolated FMU may not do: get new rights, take all memory, leave core files. Linux, as far as it goes."""

import ctypes
import os
import sys

__all__ = ["confine"]

_NO_NEW_PRIVILEGES = 38  # prctl's PR_SET_NO_NEW_PRIVS
SHARE = 2  # one in so many bytes of the machine's memory is what one FMU may have


def confine() -> None:
    """Of the calling process, for good."""
    if sys.platform == "win32":
        return
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0)
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // SHARE
        hard = resource.getrlimit(resource.RLIMIT_DATA)[1]
        most = memory if hard == resource.RLIM_INFINITY else min(memory, hard)
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))
