"""Elastic cases with known answers, a checker of your own displacements, baselines of your numbers.

from msvalidate_check import check, elastic_case

case = elastic_case("block_pull", nu=0.3, mesh="tet4")
print(check(case, case.points, my_displacement))
"""

from msvalidate_check.case_set import ElasticCase, case_names, elastic_case
from msvalidate_check.checking import FieldVerdict, assert_elastic, check
from msvalidate_check.errors import CheckError

__version__ = "0.1.0"
__all__ = [
    "CheckError",
    "ElasticCase",
    "FieldVerdict",
    "assert_elastic",
    "case_names",
    "check",
    "elastic_case",
]
