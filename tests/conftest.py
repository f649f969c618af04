"""What all tests share: the folder of photographs, and CI's promise that nothing was skipped."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
import ros_master as ros
from hypothesis import settings
from mosquitto import PROGRAM, Broker, running

settings.register_profile("untimed", deadline=None)  # no test is about how fast a machine is
settings.load_profile("untimed")


def pytest_configure() -> None:
    """Let Ctrl-C reach the programs that tests start, also where a shell's `&` has made this one deaf to it."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--forbid-skips", action="store_true", help="fail the session if any test was skipped")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """With one marker asked for, such as `-m ros`, leave out files that do not name it: importing all takes long."""
    marker = config.getoption("markexpr")
    if collection_path.suffix != ".py" or not marker.isidentifier():
        return None
    return f"mark.{marker}" not in collection_path.read_text() or None


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if session.config.getoption("--forbid-skips") and reporter and reporter.stats.get("skipped"):
        reporter.write_line(f"{len(reporter.stats['skipped'])} tests were skipped, and --forbid-skips was given")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def data_folder() -> Path:
    """Folder of the photographs and toolbox models that are not part of the project."""
    folder = os.environ.get("HAN_DATA")
    if not folder:
        pytest.skip("the environment variable HAN_DATA names no folder of photographs")
    return Path(folder)


@pytest.fixture
def broker(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Broker]:
    """A running MQTT broker of this test's own."""
    if PROGRAM is None:
        missing = "there is no mosquitto on this machine; .ci/install_mosquitto gets it"
        (pytest.fail if request.config.getoption("--forbid-skips") else pytest.skip)(missing)
    with running(tmp_path) as broker:
        yield broker


@pytest.fixture
def ros_master(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> Iterator[ros.Master]:
    """A running ROS master of this test's own, which the environment variables name."""
    if missing := ros.missing():
        (pytest.fail if request.config.getoption("--forbid-skips") else pytest.skip)(missing)
    with ros.running(tmp_path_factory.mktemp("ros")) as master:
        for name, value in master.variables.items():
            monkeypatch.setenv(name, value)
        monkeypatch.delenv("ROS_HOSTNAME", raising=False)
        yield master
