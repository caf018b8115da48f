"""The bounded run of the suite of extremes: every case that is not large by path tracing, and of
them a part by each other method.

`scripts/extremes` runs all of it with more samples.
"""

from __future__ import annotations

import pytest
from extreme_cases import all_cases
from extreme_cases.case import Case
from extreme_methods import bounded_methods_of
from extreme_runner import Effort, Runner

RUNS = [
    pytest.param(case, integrator, id=f"{case.title} by {integrator}")
    for number, case in enumerate(all_cases())
    for integrator in bounded_methods_of(case, number)
]
RUNNER = Runner(Effort())


def test_the_suite_is_as_large_as_it_should_be() -> None:
    assert len(RUNS) >= 500


@pytest.mark.parametrize(("case", "integrator"), RUNS)
def test_extreme(case: Case, integrator: str) -> None:
    verdict = RUNNER.run(case, integrator).verdict
    assert verdict.passed, verdict.figure
