"""Numbers that must stand in two places are the same in both: the paper's springs, the sets, the systems' documents."""

import pytest

from gyro_cosim import system
from gyro_cosim.gyro_unit.parameters import FULL
from gyro_cosim.systems import catalogue
from gyro_cosim.vehicle.lrt_parameters import vehicle_parameters
from gyro_cosim.vehicle.parameter_sets import parameter_set, parameter_set_names

GIMBAL = ("gimbal_stiffness", "gimbal_damping")
SYSTEMS_OF_SET_B = ("lrt-curve-b", "lrt-straight-b")


def test_set_a_is_what_vehicle_and_gyro_unit_start_with() -> None:
    """The gyro unit knows neither the vehicle nor its sets: it states Table 2's springs and set A's number of them again."""
    a = parameter_set("A")
    unit = {v.name: v.start for v in FULL}
    vehicle = {v.name: v.start for v in catalogue.component("vehicle:lrt").variables}
    assert {name: unit[name] for name in GIMBAL} == a.gyro
    # 1e-7: the set's flange angle of 71.8 deg was typed with seven right digits
    assert {name: vehicle[name] for name in a.vehicle} == pytest.approx(a.vehicle, rel=1e-7)


@pytest.mark.parametrize("kind", ["stiffness", "damping"])
def test_ranges_of_the_gimbals_springs_are_one_to_four_of_table_2(kind: str) -> None:
    one = next(v.start for v in vehicle_parameters() if v.name == f"primary_{kind}_z")
    assert next(v.assumed for v in FULL if v.name == f"gimbal_{kind}") == (one, 4 * one)


@pytest.mark.parametrize("name", SYSTEMS_OF_SET_B)
def test_the_systems_of_set_b_hold_its_gimbals(name: str) -> None:
    """A document must hold numbers: those of both gyro units are the set's."""
    units = [c for c in system(name).components if c.name.startswith("gyro")]
    assert len(units) == 2
    for unit in units:
        assert {**unit.bound, **unit.values} == parameter_set("B").gyro


def test_no_other_system_sets_a_gimbal() -> None:
    """So that what the test above compares is all there is to compare."""
    for name in set(catalogue.systems()) - set(SYSTEMS_OF_SET_B):
        for c in system(name).components:
            assert not {n for n in (*c.bound, *c.values) if n.startswith("gimbal")}


@pytest.mark.parametrize("ending", ["", "-b"])
def test_a_bare_vehicle_is_that_of_the_curve_without_what_the_units_weigh(ending: str) -> None:
    """The same track and numbers; of the table's masses and inertias only those of the gimbals are gone, 1200 kg in all."""
    (bare,), (vehicle, *units) = system(f"lrt-curve-bare{ending}").components, system(f"lrt-curve{ending}").components
    assert len(units) == 2
    assert bare.source == vehicle.source
    gone = {name for name in bare.bound if name not in vehicle.bound}
    assert {**bare.bound, **dict.fromkeys(gone, 0.0)} == {**vehicle.bound, **dict.fromkeys(gone, 0.0)}
    table = {v.name: v.start for v in catalogue.component(vehicle.source).parameters}
    assert gone == {name for name, start in table.items() if "gimbal" in name and start != 0.0}
    assert all(bare.bound[name] == 0.0 for name in gone)
    assert 2 * sum(table[name] for name in gone if name.endswith("mass")) == 1200.0


def test_the_vehicle_of_set_b_has_its_values() -> None:
    rows = {v.name: v.start for v in catalogue.component("vehicle:lrt_set_b").variables}
    assert {name: rows[name] for name in parameter_set("B").vehicle} == parameter_set("B").vehicle


@pytest.mark.parametrize("name", parameter_set_names())
def test_sets_name_variables_that_exist_and_say_where_they_come_from(name: str) -> None:
    chosen = parameter_set(name)
    assert set(chosen.vehicle) <= {v.name for v in catalogue.component("vehicle:lrt").variables}
    assert set(chosen.gyro) <= {v.name for v in FULL}
    assert "Table 2" in chosen.provenance or "equations" in chosen.provenance
