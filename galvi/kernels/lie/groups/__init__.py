"""Lie groups of vectors or matrices, one module each; galvi.kernels.lie.product combines them.

chart   number of a chart of rotations
g, k    (r,)  elements, matrices by rows;  xi, eta (d,) in the algebra, rotations first
T       (d, d)  g^-1 g' = v = T(xi) xi'
mu      (d,)  in the dual of the algebra;  slope (r,) the Euclidean derivative of a function

Functions for numbers and for lanes; for lanes, out and the arguments are lists:

place(chart, g, xi, out)               out <- g Phi(xi)
velocity(chart, xi, eta, out)          out <- T eta
rate(chart, xi, v, out)                out <- T^-1 v
momentum(chart, xi, mu, out)           out <- T^T mu
covector(chart, xi, pi, out)           out <- T^-T pi
momentum_slope(chart, xi, eta, mu, out)   out <- d(mu . T(xi) eta)/dxi
coadjoint_change(chart, xi, mu, out)   out <- Ad*_{Phi(xi)^-1} mu - mu; Ad*_{Phi(xi)^-1} mu is the
                                       body covector mu at g Phi(xi), in the frame of g
left_derivative(g, slope, out)         out <- the derivative along g hat(e_a)

Functions for numbers, of which position_scale, advance and carry also take lanes:

coadjoint(chart, xi, mu, out)          out <- Ad*_{Phi(xi)} mu
coordinates(chart, g, k, xi)           xi <- the coordinates of k in the chart at g: k = g Phi(xi)
restore(g)                             correct the orthogonality of rotations, which rounding
                                       disturbs, by one Newton step
with_rotation(chart, xi, w, out)       out <- the coordinates of Phi(xi) with rotations w, which
                                       differ from those of xi by multiples of 2 pi
position_scale(g)                      the largest |coordinate| of a position, 0 for rotations
remember(g, memory)                    memory <- the numbers that ``advance`` keeps, from g
advance(chart, xi, g, memory, low)     g <- g Phi(xi); memory and low, (r,) each, hold the rounding
                                       errors
in_space(g, mu, out)                   out <- mu along the axes of space, about the same point
carry(chart, g, g1, xi, kick, mu, nu, low)   from g to g1 = g Phi(xi): nu, before the momentum mu
                                       in space, <- that of mu + kick about the point of g1; mu <-
                                       the same in the frame of g1; low (d,) holds the rounding
                                       errors of nu
"""
