"""The claims of the papers as executable checks, one file each."""

from benchmarks.checks.claim import Claim
from benchmarks.claims.lie_groups.l01_methods_without_a_group import L1
from benchmarks.claims.lie_groups.l02_free_body_convergence_in_n import L2
from benchmarks.claims.lie_groups.l03_free_body_order import L3
from benchmarks.claims.lie_groups.l04_free_body_energy import L4
from benchmarks.claims.lie_groups.l05_momentum_spheres import L5
from benchmarks.claims.lie_groups.l06_pendulum_convergence_in_n import L6
from benchmarks.claims.lie_groups.l07_pendulum_order import L7
from benchmarks.claims.lie_groups.l08_pendulum_energy import L8
from benchmarks.claims.lie_groups.l09_pendulum_near_chart_limit import L9
from benchmarks.claims.lie_groups.l10_equivariant_interpolation import L10
from benchmarks.claims.lie_groups.l11_minima_of_the_action import L11
from benchmarks.claims.lie_groups.l12_cayley_conditioning import L12
from benchmarks.claims.lie_groups.l13_momentum_across_charts import L13
from benchmarks.claims.lie_groups.l14_other_charts_and_groups import L14
from benchmarks.claims.lie_groups.l15_curves_between_ends import L15
from benchmarks.claims.lie_groups.l16_symplecticity import L16
from benchmarks.claims.lie_groups.l17_discrete_lagrangian import L17
from benchmarks.claims.lie_groups.l18_formulas_of_the_cayley_chart import L18
from benchmarks.claims.vector_spaces.v01_oscillator_convergence_in_n import V1
from benchmarks.claims.vector_spaces.v02_oscillator_energy import V2
from benchmarks.claims.vector_spaces.v03_kepler_step_error_in_n import V3
from benchmarks.claims.vector_spaces.v04_kepler_curve_error_in_n import V4
from benchmarks.claims.vector_spaces.v05_invariants_along_curve_in_n import V5
from benchmarks.claims.vector_spaces.v06_kepler_order import V6
from benchmarks.claims.vector_spaces.v07_momentum_along_curve import V7
from benchmarks.claims.vector_spaces.v08_kepler_conservation import V8
from benchmarks.claims.vector_spaces.v09_solar_system_in_long_steps import V9
from benchmarks.claims.vector_spaces.v10_outer_planets_in_five_year_steps import V10
from benchmarks.claims.vector_spaces.v11_euler_methods_on_planets import V11
from benchmarks.claims.vector_spaces.v12_stage_iteration_contracts import V12
from benchmarks.claims.vector_spaces.v13_minima_of_the_action import V13
from benchmarks.claims.vector_spaces.v14_curves_between_ends import V14
from benchmarks.claims.vector_spaces.v15_noether_quantities import V15
from benchmarks.claims.vector_spaces.v16_symplecticity import V16
from benchmarks.claims.vector_spaces.v17_oscillator_order import V17
from benchmarks.claims.vector_spaces.v18_oscillator_convergence_in_degree import V18
from benchmarks.claims.vector_spaces.v19_well_posed_pairs import V19
from benchmarks.claims.vector_spaces.v20_contraction_constant import V20
from benchmarks.claims.vector_spaces.v21_quadrature_seminorm import V21
from benchmarks.claims.vector_spaces.v22_best_approximation import V22
from benchmarks.claims.vector_spaces.v23_brownout_order import V23
from benchmarks.claims.vector_spaces.v24_brownout_cost import V24
from benchmarks.claims.vector_spaces.v25_brownout_cloud import V25
from benchmarks.claims.vector_spaces.v26_discrete_lagrangian import V26
from benchmarks.claims.vector_spaces.v27_printed_inequalities import V27
from benchmarks.claims.vector_spaces.v28_rates_at_finite_smoothness import V28
from benchmarks.claims.vector_spaces.v29_moving_frames import V29
from benchmarks.claims.vector_spaces.v30_solution_map import V30
from benchmarks.claims.vector_spaces.v31_mass_and_potential_in_time import V31
from benchmarks.claims.vector_spaces.v32_runge_kutta_methods import V32
from benchmarks.claims.vector_spaces.v33_costs_and_step_lengths import V33
from benchmarks.claims.vector_spaces.v34_lemmas_on_the_noether_map import V34
from benchmarks.claims.vector_spaces.v35_clocks import V35
from benchmarks.claims.vector_spaces.v36_events import V36

CLAIMS: tuple[Claim, ...] = (
    *(V1, V2, V3, V4, V5, V6, V7, V8, V9, V10, V11, V12, V13, V14, V15, V16, V17, V18, V19, V20),
    *(V21, V22, V23, V24, V25, V26, V27, V28, V29, V30, V31, V32, V33, V34, V35, V36),
    *(L1, L2, L3, L4, L5, L6, L7, L8, L9, L10, L11, L12, L13, L14, L15, L16, L17, L18),
)

__all__ = ["CLAIMS", "Claim"]
