"""The inner loop of runs of FMUs: its definition, which Python runs as it stands, and the same in C.

driver          what the loop needs of a network, and whether it can run it
loop, energy    the definition
kernel.c        the same for a compiler
native          kernel.c compiled once per machine, cached, called
ctypes_calls    FMI functions as Python calls them
"""
