"""Steps of many runs of one law in vector instructions, eight members to an instruction.

Where the other kernels of lanes compute eight stages of one run at once, these compute one stage of
eight runs. No operation mixes members, and one whose step is solved is not changed any more, so
that a member's result does not depend on which others are computed with it.
"""
