"""Numbers that several folders of galvi use."""

import math

EPSILON = 2.0**-52  # spacing of float64 numbers at 1, twice the unit roundoff
LEAST_NORMAL = 2.0**-1022  # smallest normal float64 number
LARGEST_SQUARED = 1e100  # largest length or velocity whose square is safe from overflow
COMPLEX_STEP = 1e-100  # imaginary increment of derivatives by complex steps
TWO_PI = 2.0 * math.pi  # a turn, in radians
INVERSE_GOLDEN_RATIO = (5.0**0.5 - 1.0) / 2.0  # its multiples modulo 1 fill [0, 1) evenly
