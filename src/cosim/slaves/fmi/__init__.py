"""FMUs as slaves: how one is read, unpacked, loaded and called, FMI 2.0 and 3.0."""
