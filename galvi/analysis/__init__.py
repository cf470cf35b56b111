"""A-priori theory of a space, a rule and a step on a problem: constants, orders, step bounds."""
