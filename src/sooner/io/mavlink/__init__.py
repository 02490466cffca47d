"""Flights as vehicles are told them over MAVLink 2: mission, fence and rally points, sent, read back and compared."""

from sooner.io.mavlink.connection import Connection
from sooner.io.mavlink.patience import Patience
from sooner.io.mavlink.refusal import VehicleError
from sooner.io.mavlink.upload import Checked, Uploaded, upload
from sooner.io.mavlink.vehicle import Vehicle

__all__ = ["Checked", "Connection", "Patience", "Uploaded", "Vehicle", "VehicleError", "upload"]
