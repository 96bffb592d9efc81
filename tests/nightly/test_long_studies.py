"""Studies in forms that take minutes, most of them to compile kernels that nothing else needs."""

import pytest
from beds import small_bed
from project import needs_study
from small_studies import assert_works_in_its_smallest_form

import studies
from dem.sweep.config import load

CASES, LAWS = [], []
if "verification" in studies.NAMES:
    from studies.verification import broken_laws, results

    CASES, LAWS = sorted(results.CASES), broken_laws.LAWS


@needs_study("benchmark")
def test_the_benchmark_works_in_its_smallest_form(folder):
    assert_works_in_its_smallest_form("benchmark", folder)


@needs_study("benchmark")
def test_lammps_moves_undamped_beds_alike():
    """Dumbbells without friction, to the rounding of their angles; discs are compared by day."""
    from studies.benchmark.results import SMOKE, compare_motion
    from studies.benchmark.scenes import make_case
    from studies.common.peers import lammps

    if reason := lammps.available():
        pytest.skip(reason)
    bed = small_bed("dumbbell")
    cases = {"dumbbell": make_case(bed.scene(), bed.state)}
    assert compare_motion(cases, SMOKE)["trajectory_difference"][0, 0] < 1e-9


@needs_study("stability")
def test_stiff_and_extreme_cases_pass_in_a_short_form():
    """Each experiment of the catalogue, with all shapes of its first case."""
    from studies.stability import catalogue, results

    folder, experiments = studies.FOLDERS["stability"], set()
    for name, case in catalogue.load(folder / "catalogue.yaml").cases.items():
        if case.experiment not in experiments:
            experiments.add(case.experiment)
            short = case.model_copy(update={"change": case.change.model_copy(update=results.BRIEF)})
            for shape in case.shapes:
                rows = results.verdicts(load(folder / "smoke.yaml"), shape, name, short)
                assert all(row["passed"] for row in rows), rows


@pytest.mark.parametrize("name", CASES)
def test_a_case_of_verification_is_as_expected(name):
    rows, _ = results.run(name)
    assert [row for row in rows if not row.passed] == []


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.kind)
def test_a_case_of_verification_notices_a_broken_law(law):
    assert broken_laws.notices(law, law.asks)[law.asks]
