"""The calibration of Young's modulus: what calibration.yaml says."""

from pathlib import Path

import yaml

__all__ = ["calibration"]

calibration = yaml.safe_load(Path(__file__).with_name("calibration.yaml").read_text("utf-8"))
