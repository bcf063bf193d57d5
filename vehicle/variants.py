"""Variants of the vehicle of vehicle.lrt: another creep law, other parameters, conventional wheelsets."""

from gyro_cosim.component import Component

from .lrt import INTERNAL_STEP, vehicle
from .pairing import Conical
from .parameter_sets import parameter_set
from .running_gear import Design

__all__ = ["CONVENTIONAL", "lrt_fastsim", "lrt_half_space", "lrt_rough", "lrt_set_b", "lrt_shen_hedrick_elkins", "lrt_solid_axle"]

CONVENTIONAL = {
    "conicity": 0.05, "conicity_gradient": 0.0, "flange_clearance": 0.007, "rolling_radius": 0.3, "friction": 0.3,
    "flange_angle": 1.2217304763960306,  # 70 deg
}  # fmt: skip


def lrt_set_b() -> Component:
    """Make the vehicle with parameter set B: wheels almost without spin inertia.

    Returns
    -------
    Component
        The component `vehicle:lrt_set_b`.
    """
    return vehicle("lrt_set_b", "Light-rail vehicle, parameter set B", Design(), parameter_set("B").vehicle, INTERNAL_STEP)


def lrt_shen_hedrick_elkins() -> Component:
    """Make the vehicle with the law of Shen, Hedrick and Elkins on the treads.

    Returns
    -------
    Component
        The component `vehicle:lrt_shen_hedrick_elkins`.
    """
    what = "Light-rail vehicle, creep forces by Shen, Hedrick and Elkins"
    return vehicle("lrt_shen_hedrick_elkins", what, Design(law="shen-hedrick-elkins"), {}, INTERNAL_STEP)


def lrt_fastsim() -> Component:
    """Make the vehicle with FASTSIM, 7 strips of 7 cells, on the treads.

    Returns
    -------
    Component
        The component `vehicle:lrt_fastsim`.
    """
    return vehicle("lrt_fastsim", "Light-rail vehicle, creep forces by FASTSIM", Design(law="fastsim"), {}, INTERNAL_STEP)


def lrt_half_space() -> Component:
    """Make the vehicle with the forces of the exact theory of rolling contact, by a table, on the treads.

    Returns
    -------
    Component
        The component `vehicle:lrt_half_space`.
    """
    what = "Light-rail vehicle, creep forces by the exact theory"
    return vehicle("lrt_half_space", what, Design(law="half-space"), {}, INTERNAL_STEP)


def lrt_rough() -> Component:
    """Make the vehicle on track with room for random or tabulated irregularity: 48 harmonics in each of four channels.

    Returns
    -------
    Component
        The component `vehicle:lrt_rough`.
    """
    what = "Light-rail vehicle on track with random or tabulated irregularity"
    return vehicle("lrt_rough", what, Design(harmonics=48), {}, INTERNAL_STEP)


def lrt_solid_axle() -> Component:
    """Make the vehicle with conventional solid-axle wheelsets in place of the wheel pairs: 22 degrees of freedom.

    Returns
    -------
    Component
        The component `vehicle:lrt_solid_axle`.
    """
    design = Design(solid_axles=True, pairing=Conical(-1))
    return vehicle("lrt_solid_axle", "Light-rail vehicle with conventional wheelsets", design, CONVENTIONAL, INTERNAL_STEP)
