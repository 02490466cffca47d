"""Flights as aircraft and maps are told them: one plan, a file for each who reads it."""

from sooner.io.flights.aircraft import AUTOPILOTS, DJI_MODELS, Aircraft
from sooner.io.flights.flight_plan import Fence, FlightPlan, Waypoint
from sooner.io.flights.formats import FORMATS, Format

__all__ = ["AUTOPILOTS", "DJI_MODELS", "FORMATS", "Aircraft", "Fence", "FlightPlan", "Format", "Waypoint"]
