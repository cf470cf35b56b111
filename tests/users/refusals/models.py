"""Refusals of SymPy's Lagrangians, trees of rigid bodies and MuJoCo models: errors and messages."""

import numpy as np
import pytest

import galvi
from tests.properties.symbolic_letters import FOUR, FREE, from_sympy, k, m, t, u, w, x, y

sympy = pytest.importorskip("sympy")
me = pytest.importorskip("sympy.physics.mechanics")

f = sympy.Function("f")
real = sympy.Symbol("t", real=True)
th = sympy.Function("th")(t)
X, Y = me.dynamicsymbols("X Y")


def first_step(system, q, v):
    """A call that runs the first step from a start."""
    return lambda: galvi.integrate(galvi.Problem(system, q, v), FOUR, 0.1, 1)


def of_lagrange(*names, **options):
    """A call of `from_sympy` with SymPy's LagrangesMethod of X and Y and the arguments `names`."""
    method = me.LagrangesMethod(X.diff() ** 2 + Y.diff() ** 2, [X, Y], **options)
    return lambda: galvi.Lagrangian.from_sympy(method, *names)


DEGENERATE = from_sympy((u - 2 * w) ** 2 / 2 - x**2 - y**2, [x, y], [u, w])
SYMBOLIC = (
    (ValueError, r"received k, m\. Give parameters={k: ", from_sympy, m * FREE - k * x, x, u),
    (ValueError, "received m. The given m has other assumptions: use one symbol throughout",
     lambda: from_sympy(FREE * sympy.Symbol("m"), x, u, parameters={m: 1.0})),
    (ValueError, r"Give parameters={t: ...}, or t=t where it", from_sympy, FREE - x * t, x, u),
    (ValueError, r"received Derivative\(th\(t\), t\)\. .* The given Derivative\(th\(t\), t\) has",
     from_sympy, sympy.Function("th")(real).diff(real) ** 2, th),
    (ValueError, "with t = t. The given t has other", lambda: from_sympy(FREE, th, t=real)),
    (TypeError, "q must be a list, in the order .*no order", from_sympy, FREE, {x, y}, [u, w]),
    (TypeError, "force must be a list.*no order", lambda: from_sympy(FREE, x, u, force={x: -u})),
    (TypeError, "the force must be a SymPy expression", lambda: from_sympy(FREE, x, u, force="-u")),
    (ValueError, "received 1 for 2", from_sympy, FREE, [x, y], [u]),
    (ValueError, "must all differ; received x more than once", from_sympy, FREE, [x], [x]),
    (ValueError, "v must hold the velocities", from_sympy, FREE, x),
    (TypeError, r"q must hold SymPy symbols.*received \[3\]", from_sympy, FREE, [3], u),
    (TypeError, "must be a SymPy expression; received 'u", from_sympy, "u**2", x, u),
    (TypeError, r"shape \(1, 1\)\. Take its entry", from_sympy, sympy.Matrix([[FREE]]), x, u),
    (ValueError, "must be real and finite; received", from_sympy, FREE + sympy.I * x, x, u),
    (ValueError, r"for real .* I\*Abs\(x\)", from_sympy, FREE - sympy.sqrt(-(x**2)), x, u),
    (ValueError, "parameter m must be a finite",
     lambda: from_sympy(FREE, x, u, parameters={m: np.nan})),
    (TypeError, "received 'm'. Give the symbol",
     lambda: from_sympy(FREE, x, u, parameters={"m": 1.0})),
    (TypeError, "must be a dict", lambda: from_sympy(FREE, x, u, parameters=[m])),
    (ValueError, r"integrals or sums left to do; received Integral.*Call doit\(\)",
     from_sympy, FREE + sympy.Integral(sympy.exp(-(x**2)), (x, 0, x)), x, u),
    (ValueError, r"Derivative\(th, \(t, 2\)\)", from_sympy, th.diff(t) ** 2 + th.diff(t, 2), th),
    (ValueError, r"known functions; received f\(x\)", from_sympy, FREE + f(x), x, u),
    (ValueError, "compiled; received one of bess", from_sympy, FREE + sympy.besselj(0, x), x, u),
    (ValueError, "differentiable; received floor", from_sympy, FREE + sympy.floor(x), x, u),
    (ValueError, "functions of the time alone", lambda: from_sympy(th.diff(t) ** 2, th, t=x)),
    (TypeError, "t must be a SymPy symbol", from_sympy, FREE, x, u, "t"),
    (ValueError, "force must hold one .*received 2 for 1",
     lambda: from_sympy(FREE, x, u, force=[1, 2])),
    (ValueError, "the force must hold .*received k", lambda: from_sympy(FREE, x, u, force=-k * u)),
    (ValueError, r"degenerate.*along v\[0\] \+ 0\.5 v\[1\],",
     first_step(DEGENERATE, [1.0, 1.0], [1.0, 0.0])),
    (ValueError, "must return a finite number; received nan at the start",
     first_step(from_sympy(FREE - sympy.log(x), x, u), [-1.0], [1.0])),
    (ValueError, "brings its coordinates and forces", of_lagrange([X, Y])),
    (ValueError, "with constraints cannot be used; received 1", of_lagrange(hol_coneqs=[X - Y])),
    (TypeError, "q must hold the coordinates", galvi.Lagrangian.from_sympy, X.diff() ** 2),
)  # fmt: skip

HINGE = galvi.Joint("hinge")
LINK = galvi.Link(HINGE, 1.0, (0.0, 0.0, -1.0))
DAMPED = galvi.Link(galvi.Joint("hinge", damping=1.0), 1.0, (0.0, 0.0, -1.0))
ARM = [LINK, galvi.Link(galvi.Joint("hinge", damping=0.1), 0.5, (0.0, 0.0, -0.3), parent=0)]


DEGENERATE_LAGRANGIANS = (  # direction of the velocity without a momentum, Lagrangian
    (r"v\[0\] \+ v\[1\]", lambda q, v: (v[0] - v[1]) ** 2 - q[0] ** 2),
    (r"v\[1\]", lambda q, v: v[0] ** 2 + q[0] * v[1]),
    (r"v\[1\]", lambda q, v: v[0] ** 2 if q[0] < 9.0 else 0.0),  # differenced
)


def in_plane(L):
    """A call that makes a problem of a Lagrangian of two coordinates."""
    return lambda: galvi.Problem(galvi.Lagrangian(L, galvi.Rn(2)), [1.0, 0.0], [0.0, 0.0])


def varied(**parameters):
    """A call that runs a step of two arms with these parameters."""
    q, v = np.ones((2, 2)), np.zeros((2, 2))
    arms = galvi.Problem(galvi.Multibody(ARM), q[0], v[0])
    return lambda: galvi.integrate_ensemble(arms, q, v, FOUR, 0.1, 1, parameters)


TREES = (
    (ValueError, "type must be one of hinge, slide, ball, free", galvi.Joint, "screw"),
    (TypeError, "name must be a string; received 3", lambda: galvi.Joint("hinge", name=3)),
    (ValueError, "axis must have a length", lambda: galvi.Joint("hinge", axis=(0, 0, 0))),
    (ValueError, "axis must have a length", lambda: galvi.Joint("slide", axis=(1e300, 2, 0))),
    (ValueError, "damping must not be negative", lambda: galvi.Joint("hinge", damping=-1.0)),
    (ValueError, "Only hinges and slides have a zero", lambda: galvi.Joint("ball", zero=1.0)),
    (ValueError, r"rest must have shape \(3, 3\)", lambda: galvi.Joint("ball", rest=2.0)),
    (ValueError, "mass must not be negative", galvi.Link, HINGE, -1.0),
    (TypeError, "on joints with damping, force must be a function; received",
     lambda: galvi.Multibody(DAMPED, force=galvi.RotorDrag(1.0), timed_force=True)),
    (ValueError, r"force must return an array of shape \(1,\)",
     first_step(galvi.Multibody(DAMPED, force=lambda q, v: np.zeros(2)), [0.1], [0.0])),
    (ValueError, "positive semidefinite", lambda: galvi.Link(HINGE, 1.0, inertia=(1, -1, 1))),
    (ValueError, r"no body has the inertia \[1\.0, 1\.0, 5\.0\]: its largest .* or check=False",
     lambda: galvi.Link(HINGE, 1.0, inertia=(1, 5, 1))),
    (TypeError, "check must be True or False", lambda: galvi.Link(HINGE, 1.0, check=1)),
    (TypeError, "joints must be galvi.Joint values", galvi.Link, "hinge", 1.0),
    (ValueError, "must be the only one", galvi.Link, [HINGE, galvi.Joint("free")]),
    (ValueError, "nothing can move", galvi.Multibody, [galvi.Link(mass=1.0)]),
    (ValueError, "link 0 has joints, and", galvi.Multibody, [galvi.Link(HINGE)]),
    (ValueError, "parent of link", galvi.Multibody, [galvi.Link(HINGE, 1.0, parent=0)]),
    (ValueError, "between a link and the world; link 1",
     galvi.Multibody, [LINK, galvi.Link(galvi.Joint("free"), 1.0, parent=0)]),
    (ValueError, r"qpos must have shape \(1,\)",
     galvi.Multibody(LINK).from_mujoco, [0.0, 1.0], [0.0]),
    (ValueError, "a quaternion that is 0",
     galvi.Multibody(galvi.Link(galvi.Joint("ball"), 1.0)).from_mujoco, np.zeros(4),
      np.zeros(3)),
    (ValueError, "the Lagrangian is degenerate at the start",
     galvi.integrate, galvi.Problem(galvi.Multibody(galvi.Link(HINGE, 1.0, (0, 0, -1))),
      [0.0], [1.0]), FOUR, 0.1, 1),
    *(
        (ValueError, rf"degenerate at the start: .* along {axes}, or does not", in_plane(L))
        for axes, L in DEGENERATE_LAGRANGIANS
    ),
    (ValueError, "the Lagrangian is degenerate at the start",  # only there; the run checks
     first_step(galvi.Lagrangian(lambda q, v: v[0] ** 2 + (q[1] * v[1]) ** 2, galvi.Rn(2)),
        [1.0, 0.0], [0.0, 0.0])),
    (ValueError, r"'masses' must have shape \(2, 2\)", varied(masses=np.ones((2, 3)))),
    (ValueError, "mass must not be negative; received -1", varied(masses=-np.ones((2, 2)))),
    (ValueError, "armature, damping, gravity, masses, stiffness; received 'mass'",
     varied(mass=np.ones(2))),
    (ValueError, "damping must not be negative", varied(damping=np.full((2, 2), -1.0))),
)  # fmt: skip


def mujoco():
    """Rows of refused MuJoCo models; skips the test where MuJoCo is not installed."""
    engine = pytest.importorskip("mujoco")
    body = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'

    def read(world, **options):
        return lambda: galvi.from_mujoco(
            f"<mujoco><worldbody>{world}</worldbody></mujoco>", **options
        )

    def ball(**changed):
        """A model of a ball joint with entry 1 of some of its arrays changed after compilation."""
        text = f'<body><joint type="ball" damping="1"/>{body}</body>'
        model = engine.MjModel.from_xml_string(f"<mujoco><worldbody>{text}</worldbody></mujoco>")
        for name, value in changed.items():
            getattr(model, name)[1] = value
        return model

    hinge = f'<body><joint type="hinge"/>{body}</body>'
    actuated = f"""<mujoco><worldbody><body><joint name="a"/>{body}</body></worldbody><actuator>
        <position joint="a" ctrlrange="-1 1"/></actuator></mujoco>"""

    def driven(**options):
        return lambda: galvi.from_mujoco(actuated, **options)

    def with_ctrl(ctrl):
        return lambda: galvi.from_mujoco(actuated).system.with_numbers(ctrl=ctrl)

    def resumed(problem, **options):
        return lambda: galvi.resume(galvi.integrate(problem, FOUR, 0.1, 1), **options)

    return (
        (ValueError, r"ctrl\[0\] must be within .* from -1 to 1; received 7", driven(ctrl=[7.0])),
        (ValueError, r"ctrl must have shape \(1,\); received shape \(2,\)", driven(ctrl=[0, 0])),
        (ValueError, "ctrl needs actuators; .* are ignored or disabled",
         driven(ignore="actuators", ctrl=[0.1])),
        (ValueError, r"ctrl\[0\] must be within its range, from -1 to 1; received 4",
         with_ctrl([4.0])),
        (ValueError, r"ctrl must have shape \(1,\); received shape \(2,\)", with_ctrl([0.0, 0.0])),
        (ValueError, "ctrl is of the actuators of a MuJoCo model",
         resumed(galvi.problems.pendulum_3d(), steps=1, ctrl=[0.0])),
        (ValueError, "with ctrl give steps or duration; received until",
         resumed(galvi.from_mujoco(actuated), until=1.0, ctrl=[0.0])),
        (ValueError, "the model has no keyframes; received key 0", read(hinge, key=0)),
        (ValueError, "one in which nothing can move", read(f"<body>{body}</body>")),
        (ValueError, "MuJoCo cannot read the text as a model", read("<body><joint/></body>")),
        (ValueError, "cannot read the text as a model", read('<body><joint type="screw"/></body>')),
        (ValueError, "there is no file no/such/file.xml",
         galvi.from_mujoco, "no/such/file.xml"),
        (ValueError, "there is no file ä", galvi.from_mujoco, "ä" * 300),
        (TypeError, "model must be a mujoco.MjModel or MjSpec, the text of a model or a path",
         galvi.from_mujoco, 3),
        (ValueError, r"ignore must name some of contacts, .*'wind'",
         read(hinge, ignore=("contacts", "wind"))),
        (TypeError, "ignore must be names", read(hinge, ignore=3)),
        (ValueError, "the damping of joint 0 must be the same for all",
         galvi.from_mujoco, ball(dof_damping=2.0)),
        (ValueError, r"link 0 has joints, .* mass above 0; received mass 0.0",
         galvi.from_mujoco, ball(body_mass=0.0)),
        (TypeError, r"MjData\. Give its model, and its state as system\.from",
         galvi.from_mujoco, engine.MjData(ball())),
    )  # fmt: skip


TABLE = {"symbolic": SYMBOLIC, "trees": TREES}
