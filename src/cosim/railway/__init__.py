"""What a railway engineer wants to know of a run: safety against derailment, ride comfort, their filters and figures.

safety          limits of Y/Q and of guiding forces, who derailed
comfort         ride comfort of passengers by EN 12299
assessment      what one run says of each railway vehicle in it
filters         of EN 14363
yaw_stability   whether a gyro can stabilise free wheels: a necessary condition in closed form
figures         a run along the track
field           all this for the command line

Only the command line, the paper and the studies use this: the master is general.
"""
