"""sooner plans where drones look, so that a lost person is found sooner."""

__version__ = "0.1.0"
