# SPDX-License-Identifier: Apache-2.0
"""Simulates soft limbs bent by shape memory alloy and other plants, fits them to recordings, and finds the physics they leave out.

    plant = sinew.Plant("plant/limbs/paper_limb.yaml")
    recording = sinew.Recording("scenarios/demo/recording.csv")
    answer = sinew.diagnose(plant, train=[recording])
"""
from ._core import Effect, Law, Parameter, Plant, Predictor, Recording, Rollout, Simulation, __commit__, __version__
from .errors import InputError, IntegrationError
from .mappings import Effects, Parameters
from .results import Answer, Calibration, calibrate, diagnose

Plant.parameters = property(Parameters)
Plant.effects = property(Effects)

__all__ = ["Answer", "Calibration", "Effect", "Effects", "InputError", "IntegrationError", "Law", "Parameter", "Parameters", "Plant",
           "Predictor", "Recording", "Rollout", "Simulation", "calibrate", "diagnose", "__commit__", "__version__"]
