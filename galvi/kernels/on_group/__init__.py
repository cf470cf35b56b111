"""Steps of any Lagrangian on a Lie group, in a chart, by Newton's method."""
