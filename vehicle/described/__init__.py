"""Vehicles from files: what a .toml file says becomes a component.

    values, sections     a number with its unit or a formula of parameters; a table read key by key
    description          the vehicle as a value
    reading, rules       from file to description; what a vehicle must be
    statics, elements    what springs carry at rest; what they do
    equations            the equations of motion, put together from the parts of `vehicle`
    rows, component      signals; the component

Public: `reading.read`, `component.component_of` and `component.component_of_file`. docs/vehicle-files.md is the schema.
"""
