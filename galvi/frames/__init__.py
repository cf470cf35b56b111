"""Frames that move with an integrable flow; `FRAMES` drives the tests."""

from galvi.frames.frame import Frame
from galvi.frames.harmonic_frame import HarmonicFrame
from galvi.frames.kepler_frame import KeplerFrame

FRAMES: tuple[Frame, ...] = (HarmonicFrame(), KeplerFrame())
