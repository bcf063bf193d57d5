"""How far each claim of the paper holds: draws from the ranges of what it does not give, and what they say.

open_parameters                 what may be drawn
draws, pair_draws, vehicle_draws    a study and its rows
statistics, findings            shares with their interval, influences
page, figures, study            what is written down
"""
