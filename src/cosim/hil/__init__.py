"""A test rig in a component's place: delay and its margin, compensation, real time.

delay_margin    the largest delay at which a system stays stable
compensation    what can be done about a delay where the answer comes in
sampled_model   the system with its delays, linearised at the communication points
delayed_slave   a slave behind a delay
realtime        a run paced to the wall clock
figures         margins and timing drawn
"""
