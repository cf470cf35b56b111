"""Frames that move with an integrable flow; `FRAMES` drives the tests."""

from galvi.fast.frames.frame import Frame
from galvi.fast.frames.harmonic_frame import HarmonicFrame
from galvi.fast.frames.kepler_frame import KeplerFrame

FRAMES: tuple[Frame, ...] = (HarmonicFrame(), KeplerFrame())
