"""A test rig in a component's place: delay and its margin, compensation, real time."""
