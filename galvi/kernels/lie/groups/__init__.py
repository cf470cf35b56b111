"""Lie groups of vectors or matrices, one module each; galvi.kernels.lie.product combines them.

chart   number of a chart of rotations
g, k    (r,)  elements, matrices by rows;  xi, eta (d,) in the algebra, rotations first
T, G    (d, d)  g^-1 g' = T(xi) xi',  G = d(T(xi) eta)/dxi; initially zero
mu      (d,)  in the dual of the algebra;  slope (r,) the Euclidean derivative of a function

place(chart, g, xi, out)               out <- g Phi(xi)
tangent(chart, xi, eta, T, G)
coordinates(chart, g, k, xi)           xi <- the coordinates of k in the chart at g: k = g Phi(xi)
restore(g)                             correct the orthogonality of rotations, which rounding
                                       disturbs, by one Newton step
coadjoint_inverse(chart, xi, mu, out)  out <- Ad*_{Phi(xi)^-1} mu: a body covector at g Phi(xi),
                                       in the frame of g
coadjoint(chart, xi, mu, out)          out <- Ad*_{Phi(xi)} mu, its inverse
left_derivative(g, slope, out)         out <- the derivative along g hat(e_a)
with_rotation(chart, xi, w, out)       out <- the coordinates of Phi(xi) with rotations w, which
                                       differ from those of xi by multiples of 2 pi
position_scale(g)                      the largest coordinate of a position, 0 for rotations
"""
