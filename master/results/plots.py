"""Pictures of a run in one line, by the functions that draw a case's pictures."""

from typing import TYPE_CHECKING, Any
from warnings import warn

from ..case.schema import Case
from ..case.shown import Picture
from ..fmi.errors import BadInput, names_of, unknown
from .coordinates import crank_angle_port
from .pictures import DRAWN, figures, left_out

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .recorded import Recorded


class Plots:
    """Plots of a run, `results.plot`; each call draws one matplotlib figure.

    A notebook shows the figure, a script saves it (`figure.savefig("film.png")`). `units` maps
    names to units ("um", "MPa", "deg"). Default: SI. `beside` adds other runs to the same panels:
    label -> Results.

    Examples
    --------
    >>> results = pc.open_case("two_mass_oscillator", {"time.stop": "0.02 s"}).run()
    >>> figure = results.plot.lines("left.displacement", units={"left.displacement": "mm"})
    >>> figure.axes[0].get_ylabel()
    'displacement [mm]'
    """

    def __init__(self, results: "Recorded", case: Case):
        self._results, self._case = results, case

    def __repr__(self) -> str:
        return f"<Plots of {self._results.path.name}: lines, map, section>"

    def __call__(self, beside: "dict[str, Recorded] | None" = None) -> "dict[str, Figure]":
        """Draw the pictures that the case describes: file name -> figure.

        A warning names those that the runs do not have the fields or instants for.
        """
        runs = self._runs(beside)
        for file, why in left_out(self._case, runs).items():
            warn(f"{file} is omitted: {why}", stacklevel=2)
        return {picture.file: figure for picture, figure in figures(self._case, runs)}

    def lines(
        self,
        *ports: str,
        x: str | None = None,
        units: dict[str, str] | None = None,
        beside: "dict[str, Recorded] | None" = None,
    ) -> "Figure":
        """Draw scalar outputs over `x`, a panel each.

        Parameters
        ----------
        *ports : str
            "participant.variable".
        x : str, optional
            Abscissa. Default: crank angle, or time in a case without a crank.
        """
        x = x or self._abscissa()
        self._check_ports([*ports, *([x] if x != "time" else [])], self._results.ports)
        y = [[port] for port in ports]
        picture = _picture("lines", x=ports[0], y=y, units=units or {})
        return self._drawn(picture.model_copy(update={"x": x}), beside)

    def map(
        self,
        *ports: str,
        time: str,
        units: dict[str, str] | None = None,
        beside: "dict[str, Recorded] | None" = None,
    ) -> "Figure":
        """Draw maps of recorded fields at the instant nearest to `time` ("18 ms"), a row each."""
        self._check_ports(ports, self._results.recorded)
        chosen = dict(fields=list(ports), time=time, units=units or {})
        return self._drawn(_picture("map", **chosen), beside)

    def section(
        self,
        *ports: str,
        time: str,
        height: float = 0.5,
        angles: tuple[str, str] = ("0 deg", "360 deg"),
        units: dict[str, str] | None = None,
        beside: "dict[str, Recorded] | None" = None,
    ) -> "Figure":
        """Draw recorded fields at `time` along the first index, at share `height` of the second."""
        self._check_ports(ports, self._results.recorded)
        where = dict(fields=list(ports), time=time, height=height, angles=angles)
        return self._drawn(_picture("section", **where, units=units or {}), beside)

    def _abscissa(self) -> str:
        port = crank_angle_port(self._case)
        return port if port is not None and port in self._results.ports else "time"

    def _check_ports(self, ports: Any, known: list[str]) -> None:
        """Raise `BadInput` for ports that the file does not have."""
        unknown_ports = [port for port in ports if port not in known]
        if unknown_ports:
            raise BadInput([f"plot: {unknown('variable', port, known)}" for port in unknown_ports])
        if not ports:
            raise BadInput(f"plot: expected {names_of(known)}, got nothing")

    def _runs(self, beside: "dict[str, Recorded] | None") -> "dict[str, Recorded]":
        return {self._results.path.stem: self._results, **(beside or {})}

    def _drawn(self, picture: Picture, beside: "dict[str, Recorded] | None") -> "Figure":
        return DRAWN[picture.kind](self._case, picture, self._runs(beside))


def _picture(kind: str, **options: Any) -> Picture:
    return Picture.model_validate(dict(file=f"{kind}.png", title="", kind=kind) | options)
