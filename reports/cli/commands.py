"""The commands of ``galvi``, which are those of ``python -m reports``, and their exit status.

0    nothing worse and nothing unexpected; absent engines that were not required, new integrators,
     and benchmarks that neither side can run are listed, and are no failure
1    something got worse, a verdict is not as expected, a study failed, a required engine is absent,
     or a judged run does not reach its error
2    the command could not be carried out, with one sentence why: in CI, treat it as a failure
130  interrupted
"""

from __future__ import annotations

import math
import shlex
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from benchmarks.store.atomic import write
from reports.cli.errors import UsageError, choose_claims, choose_engines, sentence
from reports.cli.merge import merge_command
from reports.results.options import OUT, OWN_FOLDER, Options

if TYPE_CHECKING:
    from reports.results.suite import Suite

Load = Callable[[], "Suite"]
INTERRUPTED = 130
PROGRAM = ("python", "-m", "reports")
QUICK = typer.Option(False, "--quick", help="Fewer and shorter runs.")
REQUIRE = typer.Option(
    None, "--require", metavar="rebound,mujoco", help="Engines whose absence is a failure."
)
CLAIMS = typer.Option("", "--claims", metavar="V3,V5", help="Only these claims.")
CONTENDER = typer.Option(
    [],
    "--contender",
    metavar="package.module:Class",
    help="An external integrator to include in the comparison; may be repeated.",
)
TRACKED = typer.Option(
    [],
    "--contender",
    metavar="package.module:Class",
    help="An integrator of the repository around this folder, to track; may be repeated.",
)
PROBLEM = typer.Option(
    [],
    "--problem",
    metavar="package.module:function",
    help="A problem of your own to compare on, in place of the suite's; may be repeated.",
)
ONLY = typer.Option(
    "", "--only", metavar="top,kepler", help="Only problems with one of these in their names."
)
ANEW = typer.Option(False, "--anew", help="Start over instead of resuming an interrupted build.")
KEPT = typer.Option(False, "--kept", help="Only draw and write the pages, from kept rows.")
SCHEDULER = typer.Option(
    "",
    "--scheduler",
    metavar="ADDRESS",
    help="Of a Dask scheduler: studies without timings run there.",
)
SINGLE = typer.Option(False, "--single-file", help="Also write all pages as one file.")
FOLDERS = typer.Argument(..., metavar="FOLDER...", help="What `compare` or `make bench` wrote.")
FOLDER = typer.Option(OUT, "--out", metavar="DIR", help="Output folder.")


def application(load: Load, command: str, called: str = shlex.join(PROGRAM)) -> typer.Typer:
    """The typer application for the suite that `load` returns; commands return the exit status."""
    app = typer.Typer(
        add_completion=False,
        rich_markup_mode=None,
        help="Check the papers' claims, compare methods, and write tables, figures and a page.",
    )

    def options(
        suite: Suite,
        quick: bool,
        out: Path,
        claims: str = "",
        require: str | None = None,
        contenders: Sequence[str] = (),
        anew: bool = False,
    ) -> Options:
        chosen = choose_claims(claims, [claim.id for claim in suite.claims])
        engines = () if require is None else choose_engines(require, suite.engines())
        check_folder(out)
        return Options(quick, chosen, out, command, engines, tuple(contenders), anew, called)

    @app.callback(invoke_without_command=True)
    def everything(
        context: typer.Context,
        quick: bool = QUICK,
        claims: str = CLAIMS,
        contender: list[str] = CONTENDER,
        anew: bool = ANEW,
        out: Path = FOLDER,
    ) -> int:
        if context.invoked_subcommand is None:
            return build_all(quick, claims, None, contender, anew, False, False, "", out)
        named = (("quick", quick), ("claims", claims), ("contender", contender), ("anew", anew))
        given = [f"--{name}" for name, value in named if value]
        given += ["--out"] if out != OUT else []
        if given:
            raise typer.BadParameter(
                f"{' and '.join(given)} must follow the command, "
                f"as in: {context.invoked_subcommand} {given[0]}."
            )
        return 0

    @app.command("verify", help="Check the claims; exit 1 when a verdict is not as expected.")
    def verify_claims(
        quick: bool = QUICK,
        claims: str = CLAIMS,
        require: str = REQUIRE,
        contender: list[str] = CONTENDER,
        scheduler: str = SCHEDULER,
        out: Path = FOLDER,
    ) -> int:
        from reports.build.verify import verify
        from reports.build.workers import on_scheduler
        from reports.results.own_problems import joined

        with joined(load(), contender) as known, on_scheduler(known, scheduler) as suite:
            passed = verify(suite, options(suite, quick, out, claims, require)).passed
            faults = list(suite.faults())
        for fault in faults:
            print(fault, file=sys.stderr)
        return int(not passed or bool(faults))

    @app.command("compare", help="Time galvi and other codes at matched error.")
    def compare_methods(
        quick: bool = QUICK,
        only: str = ONLY,
        contender: list[str] = CONTENDER,
        problem: list[str] = PROBLEM,
        out: Path = FOLDER,
    ) -> int:
        from reports.build.compare import compare, compare_sections
        from reports.results.only import narrowed
        from reports.results.own_problems import joined, with_problems

        known = with_problems(load(), problem, bool(contender)) if problem else load()
        if problem:
            out = OUT / "own" if out == OUT else out  # full results stay
        if only:
            try:
                known = narrowed(known, only, quick)
            except ValueError as error:
                raise typer.BadParameter(f"--only: {error}") from None
            out = OUT / "only" if out == OUT else out  # full results stay
        with joined(known, contender) as suite:
            asked = options(suite, quick, out)
            failures = [
                *compare(suite, asked).measured.failures,
                *(one.failure for one in compare_sections(suite, asked) if one.failure),
                *suite.faults(),
            ]
        failures = list(dict.fromkeys(failures))
        for failure in failures:
            print(failure, file=sys.stderr)
        print(f"Tables are in {out / 'tables'}.")
        return int(bool(failures))

    @app.command(
        "build", help="Everything, with figures and the page; resumes an interrupted build."
    )
    def build_all(
        quick: bool = QUICK,
        claims: str = CLAIMS,
        require: str = REQUIRE,
        contender: list[str] = CONTENDER,
        anew: bool = ANEW,
        kept: bool = KEPT,
        single: bool = SINGLE,
        scheduler: str = SCHEDULER,
        out: Path = FOLDER,
    ) -> int:
        from reports.build.build import build, build_kept
        from reports.build.workers import on_scheduler
        from reports.results.own_problems import joined

        known = load()
        if kept:
            try:
                build_kept(known, options(known, quick, out), single)
            except ValueError as error:
                raise typer.BadParameter(f"--kept: {error}") from None
            return 0
        with joined(known, contender) as here, on_scheduler(here, scheduler) as suite:
            asked = options(suite, quick, out, claims, require, contender, anew)
            verified, compared, sections = build(suite, asked, single)
            failures = [
                *compared.measured.failures,
                *(one.failure for one in sections if one.failure),
                *suite.faults(),
            ]
        for failure in dict.fromkeys(failures):
            print(failure, file=sys.stderr)
        return int(not verified.passed or bool(failures))

    @app.command("studies", help="Run the long studies (hours); resumes after an interruption.")
    def long_studies(
        only: str = typer.Option(
            "", "--only", metavar="mutants,turning", help="Only these studies."
        ),
        minutes: float = typer.Option(math.inf, metavar="M", help="Start no run after so many."),
        out: Path = FOLDER,
    ) -> int:
        from reports.build.sections import run_long_forms

        suite = load()
        try:
            failures = run_long_forms(suite, options(suite, False, out), only, minutes)
        except ValueError as error:
            raise typer.BadParameter(f"--only: {error}") from None
        for failure in failures:
            print(failure, file=sys.stderr)
        return int(bool(failures))

    @app.command(
        "export", help="Write a table as CSV, Parquet, LaTeX or Markdown, or a figure for a paper."
    )
    def export_table(
        name: str = typer.Argument(
            "", metavar="NAME", help="E.g. work_precision, ratios, numbers, fig-3-02."
        ),
        listed: bool = typer.Option(False, "--list", help="Say what there is, instead of NAME."),
        every: bool = typer.Option(False, "--all", help="All tables, or figures, not NAME."),
        where: list[str] = typer.Option(
            [], "--where", metavar="problem=kepler", help="Rows to take; several narrow it down."
        ),
        columns: str = typer.Option(
            "", "--columns", metavar="error,seconds", help="Columns to take."
        ),
        form: str = typer.Option(
            "csv",
            "--format",
            metavar="parquet|latex|csv|markdown|pdf|svg|png",
            help="Of a table, or one of the last three of a figure.",
        ),
        sort: str = typer.Option(
            "", "--sort", metavar="error,-seconds", help="Columns to sort by."
        ),
        to: Path = typer.Option(
            None, "--to", metavar="FILE", help="Output file; default in tables/ or figures/."
        ),
        width: str = typer.Option(
            "page", "--width", metavar="column|page", help="Of a figure for a paper."
        ),
        out: Path = FOLDER,
    ) -> int:
        from reports.cli.export import Choice, exported

        choice = Choice(*(_words(text) for text in (sort, columns)), tuple(where))
        for line in exported(load, out, name, form, width, to, choice, listed, every):
            print(line)
        return 0

    @app.command(
        "track", help="Show the benchmark history; with --against, compare with a revision."
    )
    def track_performance(
        against: str = typer.Option(None, "--against", metavar="REV", help="A commit or a branch."),
        only: list[str] = typer.Option(
            [], "--only", metavar="TEXT", help="Benchmarks with this in their names."
        ),
        isolate: bool = typer.Option(
            False, "--isolate", help="Give each side its own environment (minutes)."
        ),
        contender: list[str] = TRACKED,
        quick: bool = QUICK,
        out: Path = FOLDER,
    ) -> int:
        from reports.cli.track import track_command

        suite = load()
        options(suite, quick, out)  # rejects an --out that is not a folder
        return track_command(
            out, suite.provenance(command), against, only, quick, isolate, contender
        )

    @app.command(
        "judge", help="How wrong a model's own run is, and what reaches an error cheapest."
    )
    def judge_model(
        file: Path = typer.Argument(
            ...,
            metavar="FILE",
            help="A file of REBOUND's, or a model of MuJoCo's (.xml, .mjb, .urdf).",
        ),
        duration: float = typer.Option(
            None,
            "--duration",
            metavar="T",
            help="In the model's time; without it 100 revolutions of the fastest body, or 10 s.",
        ),
        error: float = typer.Option(
            None,
            "--error",
            metavar="E",
            help="Largest error allowed; exit 1 when your run is worse.",
        ),
        own: str = typer.Option(
            "",
            "--own",
            metavar="integrator=whfast,dt=0.1",
            help="Integrator, step and options of the run to judge, where not as in the file.",
        ),
        snapshot: int = typer.Option(
            -1, "--snapshot", metavar="N", help="Of an archive; -1: the last."
        ),
        key: str = typer.Option(
            None, "--key", metavar="NAME|N", help="Keyframe of a model to start at."
        ),
        ignore: str = typer.Option(
            "", "--ignore", metavar="contacts,limits", help="What of a model to leave out."
        ),
        qpos: str = typer.Option(
            "", "--qpos", metavar="1,0.5", help="Start of a model: positions."
        ),
        qvel: str = typer.Option(
            "", "--qvel", metavar="0,0.1", help="Start of a model: velocities."
        ),
        ctrl: str = typer.Option(
            "", "--ctrl", metavar="0,0.1", help="Constant controls of a model's actuators."
        ),
        quick: bool = typer.Option(
            False, "--quick", help="Shorter looks at other sources and integrators."
        ),
        extras: str = typer.Option(
            "",
            "--extras",
            metavar="FILE",
            help="Forces of REBOUNDx in a simulation, as rebx.save(FILE) writes.",
        ),
        request: Path = typer.Option(None, "--request", hidden=True),  # of galvi.judge
        out: Path = typer.Option(OUT / "judge", "--out", metavar="DIR", help="Output folder."),
    ) -> int:
        from galvi.interop.judge import JudgeRequest
        from reports.cli.judge import judge_command, request_of

        check_folder(out)
        states = {"qpos": qpos, "qvel": qvel, "ctrl": ctrl}
        asked = (
            request_of(duration, error, own, snapshot, ignore, key, states, quick, extras)
            if request is None
            else JudgeRequest.from_json(request.read_text(encoding="utf-8"))
        )
        return judge_command(file, asked, out, command)

    @app.command("warm", help="Compile the kernels of galvi.problems: about two minutes, once.")
    def warm_kernels() -> int:
        from reports.build.warm import warm

        warm()
        return 0

    @app.command("merge", help="Bring in kept rows and benches of other machines' reports.")
    def merge_reports(folders: list[Path] = FOLDERS, out: Path = FOLDER) -> int:
        return merge_command(check_folder(out), folders)

    @app.command("readme", help="Update the tables and pictures of README.md and docs/.")
    def renew_readme(out: Path = FOLDER) -> int:
        from reports.tables.readme import renew

        if not (written := renew(Path(), out)):
            raise typer.BadParameter(f"{out} holds no rows of them yet; run build first.")
        print(f"Renewed: {', '.join(written)}.")
        return 0

    return app


def _words(text: str) -> tuple[str, ...]:
    """The words of a list with commas."""
    return tuple(word.strip() for word in text.split(",") if word.strip())


def check_folder(out: Path) -> Path:
    """The output folder, made. Raises typer.BadParameter where nothing can be written in it."""
    if out.exists() and not out.is_dir():
        raise typer.BadParameter(f"--out expects a folder; received the file {out}.")
    try:
        out.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=out).close()
        if OWN_FOLDER in out.parts[:1] and not (Path(OWN_FOLDER) / ".gitignore").exists():
            write(Path(OWN_FOLDER) / ".gitignore", "*\n")
    except OSError as error:
        raise typer.BadParameter(f"--out expects a folder to write in; {error}.") from None
    return out


def run(load: Load, arguments: Sequence[str], called: Sequence[str] = PROGRAM) -> int:
    """Run the command; returns the exit status. Usage errors become one sentence on stderr.

    called  the words before the arguments, as usage and provenance name the command
    """
    app: Any = application(load, shlex.join([*called, *arguments]), " ".join(called))
    try:
        status = app(list(arguments), prog_name=" ".join(called), standalone_mode=False)
    except UsageError as error:
        print(sentence(error, [one.name for one in app.registered_commands]), file=sys.stderr)
        return 2
    except (KeyboardInterrupt, typer.Abort):
        status = INTERRUPTED
    if status == INTERRUPTED:  # typer's status for an interrupt, too
        print("Interrupted; the files that were written are whole.", file=sys.stderr)
    return int(status or 0)
