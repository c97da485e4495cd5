"""The whole cycles are slow: `pytest -m "not slow"` leaves them out."""


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: minutes; whole cycles")
