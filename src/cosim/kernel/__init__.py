"""The inner loop: one source that Python runs as it stands and that is compiled for long runs, with its calls into FMUs."""
