"""What stays in control where foreign code runs: it loads nothing, so that it may stand before everything else.

keeper       a process that keeps another one, its fork
last_word    what a process still does when foreign code ends it
"""
