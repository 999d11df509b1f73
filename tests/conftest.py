"""What every test shares: the slow option, skips in CI, hypothesis profiles, a drawing backend
without a screen.
"""

import os
import signal
import time
from collections.abc import Generator
from pathlib import Path
from typing import TypeVar

import matplotlib
import pytest
from hypothesis import settings
from hypothesis.configuration import set_hypothesis_home_dir

from halfplane_fe.condensed_bodies import BODY_CACHE
from shared_runs import share

# A shell that starts the tests in the background has Ctrl-C ignored, here and in every process
# started from here.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Work counts are asserted: no condensed body may come from an earlier test. The tests of the cache
# have caches of their own.
BODY_CACHE.bound_bytes = 0
share()

IN_CI = os.environ.get("CI", "").lower() in {"1", "true"}
Report = TypeVar("Report", pytest.TestReport, pytest.CollectReport)
# Cases of families of which others stay among the fast tests, and dear tests with cheaper ones
# beside them: without them `make test` takes minutes less.
COSTLY = frozenset(Path(__file__).with_name("costly.txt").read_text(encoding="utf-8").splitlines())
BEGUN = pytest.StashKey[float]()  # when this process began to test [s]
SLOW_REASON = "slow: run by make slow, --slow or -m slow"

matplotlib.use("Agg")
set_hypothesis_home_dir(Path(__file__).parents[1] / ".cache" / "hypothesis")
# A deadline would fail on a busy machine, not on a wrong program. In CI the examples are the same
# each time: a red run can be repeated.
settings.register_profile("local", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if IN_CI else "local")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--slow", action="store_true", help="run the tests marked slow as well")
    parser.addoption(
        "--within",
        type=float,
        metavar="SECONDS",
        help="skip the tests that have not begun by then, and count them (make quick)",
    )


def pytest_sessionstart(session: pytest.Session) -> None:
    session.config.stash[BEGUN] = time.monotonic()


def pytest_runtest_setup(item: pytest.Item) -> None:
    seconds = item.config.getoption("--within")
    if seconds is not None and time.monotonic() - item.config.stash[BEGUN] > seconds:
        pytest.skip(f"not begun within {seconds:g} s")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    by_name = {item.nodeid.removeprefix("tests/"): item for item in items}
    for name in COSTLY & by_name.keys():
        by_name[name].add_marker(pytest.mark.slow)
    if _slow_wanted(config):
        return
    for item in items:
        if item.get_closest_marker("slow"):
            item.add_marker(pytest.mark.skip(reason=SLOW_REASON))


def _slow_wanted(config: pytest.Config) -> bool:
    return bool(config.getoption("--slow")) or "slow" in config.getoption("markexpr")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    return _refuse_skip(report) if report.skipped and not _may_skip(item, report) else report


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report() -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    report = yield
    return _refuse_skip(report) if report.skipped and IN_CI else report


def _may_skip(item: pytest.Item, report: pytest.TestReport) -> bool:
    unasked = item.get_closest_marker("slow") is not None and not _slow_wanted(item.config)
    return not IN_CI or hasattr(report, "wasxfail") or unasked


def _refuse_skip(report: Report) -> Report:
    """In CI a test that can't run is a failure: nothing may pass by being skipped, save slow tests
    that are not asked for.
    """
    reason = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    report.outcome = "failed"
    report.longrepr = f"skipped in CI, where only slow tests may be, and only unasked: {reason}"
    return report
