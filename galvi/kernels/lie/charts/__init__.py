"""Charts of rotations, one module each.

With u = |xi|^2 and angles in radians, the rotation is about the axis xi / |xi|:

SINGULAR_ANGLE     angle at which the chart or its tangent map becomes singular
LARGEST_IN_STEP    largest |xi| of a rotation within a step, that of 0.995 SINGULAR_ANGLE
LARGEST_IN_LANES   largest |xi| for which lanes are used: functions of u are accurate in lanes there
rotation(u)      (sine, cosine):  R = I + sine hat(xi) + cosine hat(xi)^2
tangent(u)       ((a, b, c), (a1, b1, c1), (a2, b2, c2)):  R^T R' = hat(T xi'),
                 T = a I - b hat(xi) + c xi xi^T, with a1 = da/du, a2 = d^2a/du^2, and so on
inverse(u)       (k, d):  T^-1 = k I + hat(xi) / 2 + d xi xi^T
translation(u)   ((e, f), (e1, f1), (e2, f2)):  V = I + e hat(xi) + f hat(xi)^2; the chart of a
                 rigid motion maps (xi, v) to the rotation of xi and the translation V v
half_turn(u)     (a, b): the rotation's quaternion is (1 + b, a xi)
from_quaternion(w, sine)   factor: xi = factor (x, y, z) for the unit quaternion (w, x, y, z) with
                 w >= 0 and sine = |(x, y, z)|
angle(x)         the signed angle of a rotation of the plane with coordinate x
coordinate(angle)          the inverse of ``angle``: the coordinate x

Functions of u take lanes, too; values that do not depend on u are then numbers.
"""
