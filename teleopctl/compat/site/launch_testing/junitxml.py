"""``launch_testing.junitxml``: results as xUnit reports."""

from __future__ import annotations

import unittest
import xml.etree.ElementTree as ET  # only written here
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .test_result import FailResult, SkipResult, TestResult

    Result = FailResult | SkipResult | TestResult


# Any: launches, or their names.
def unittestResultsToXml(  # noqa: N802 -- the original's name
    *, test_results: Mapping[Any, Result], name: str = "launch_test"
) -> ET.ElementTree[ET.Element]:
    """Return the report of several launches.

    Args:
        test_results: The result of each.
        name: Name of the report.
    """
    results = test_results.values()
    root = ET.Element(
        "testsuites",
        name=name,
        tests=str(sum(result.testsRun for result in results)),
        failures=str(sum(len(result.failures) for result in results)),
        errors=str(sum(len(result.errors) for result in results)),
        time=_seconds(sum(sum(result.testTimes.values()) for result in results)),
    )
    root.extend(unittestResultToXml(str(run), result) for run, result in test_results.items())
    return ET.ElementTree(root)


def unittestResultToXml(name: str, test_result: Result) -> ET.Element:  # noqa: N802 -- likewise
    """Return the report of one launch."""
    suite = ET.Element(
        "testsuite",
        name=name,
        tests=str(test_result.testsRun),
        failures=str(len(test_result.failures)),
        errors=str(len(test_result.errors)),
        skipped=str(len(test_result.skipped)),
        time=_seconds(sum(test_result.testTimes.values())),
    )
    suite.extend(unittestCaseToXml(test_result, case) for case in test_result.testCases)
    return suite


def unittestCaseToXml(  # noqa: N802 -- likewise
    test_result: Result, test_case: unittest.TestCase
) -> ET.Element:
    """Return the report of one test."""
    # The values of a parametrized launch follow the name, and may have spaces and dots.
    path, space, values = test_case.id().partition(" ")
    class_name, _, name = path.rpartition(".")
    element = ET.Element(
        "testcase",
        classname=class_name,
        name=name + space + values,
        time=_seconds(test_result.testTimes[test_case]),
    )
    for kind, told in (
        ("failure", test_result.failures),
        ("error", test_result.errors),
        ("skipped", test_result.skipped),
    ):
        for case, message in told:
            # A subtest has the time of its test.
            if getattr(case, "test_case", case) is test_case:
                ET.SubElement(element, kind, message=message)
    return element


def _seconds(seconds: float) -> str:
    return str(round(seconds, 3))
