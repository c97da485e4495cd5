"""Lubrication models side by side on one case: what they make of film, load and friction, and what
they cost.

The measures need nothing but the fields of the contract, so that any two lubrication FMUs can be
held against each other.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..case.contract import contract, swap
from .pictures import PALETTE

MEASURES = {
    "thinnest film": "um",
    "film, rms distance": "um",
    "load, mean": "N",
    "friction force, mean size": "N",
    "friction power, mean": "W",
    "iterations a step, mean": "",
    "iterations a step, most": "",
    "wall time": "s",
}


def rival_trees(tree, models):
    """Trees of the case with each lubrication model, and one whose pictures all of them can fill.

    Parameters
    ----------
    tree : dict
        The case's TOML tree.
    models : list of str
        Each the path of an FMU (*.fmu), or a cavitation model of the case's own FMU.

    Returns
    -------
    trees : dict of str to dict
        By model: file name without suffix, or cavitation model.
    common : dict
    left_out : dict of str to list of str
        What the case says of variables that an FMU does not have, by model.
    """
    name, trees, left_out, common = contract()["lubrication"]["participant"], {}, {}, tree
    for model in models:
        if model.endswith(".fmu"):
            label = Path(model).stem
            trees[label], left_out[label] = swap(tree, name, Path(model))
            common, _ = swap(common, name, Path(model))
        else:
            own = tree["participants"][name]
            parameters = own.get("parameters", {}) | {"cavitation_model": model}
            trees[model] = tree | {
                "participants": tree["participants"] | {name: own | {"parameters": parameters}}
            }
    for label, each in trees.items():
        record = each.get("record", {})
        fields = list(dict.fromkeys([*record.get("fields", []), *ports().values()]))
        # halved steps would shift every n-th row
        trees[label] = each | {"record": record | {"fields": fields, "every": 1}}
    return trees, common, left_out


def ports():
    """The fields that cross the interface: name in the contract -> participant.name, as the side
    that gives it records it.
    """
    terms = contract()
    return {
        field: f"{role['participant']}.{field}"
        for role in (terms["bodies"], terms["lubrication"])
        for field in role["outputs"]["field"]
    }


def curves(results):
    """What a run recorded, at the instants of its fields.

    Eq. (V1):  thinnest film = min h,  load = sum F_p,  friction = sum F_f,  friction power = -sum F_f V

    Returns
    -------
    dict
        time [s], shape (n,); film [m], shape (n, n_c, n_a); thinnest [m], load [N], friction [N],
        power [W], shape (n,); V is the sliding velocity [m/s], F_p and F_f are the nodal forces
        [N].
    """

    def field(name):
        return results.file["fields/" + ports()[name].replace(".", "/")][:]

    film, friction = field("film_thickness"), field("nodal_friction_force")
    # Eq. (V1)
    return {
        "time": results.file["fields/time"][:],
        "film": film,
        "thinnest": film.min(axis=(1, 2)),
        "load": field("nodal_pressure_force").sum(axis=(1, 2)),
        "friction": friction.sum(axis=(1, 2)),
        "power": -(friction * field("sliding_velocity")).sum(axis=(1, 2)),
    }


def distance(one, first):
    """Instants that both recorded [s], and there the root mean square difference of two films over
    the cells [m].
    """
    shared, here, there = np.intersect1d(one["time"], first["time"], return_indices=True)
    return shared, np.sqrt(np.mean((one["film"][here] - first["film"][there]) ** 2, axis=(1, 2)))


def measures(found, summaries):
    """Values of `MEASURES`, in their units, for every model.

    Parameters
    ----------
    found, summaries : dict
        By model: `curves` and the summary of its run; the first is what the others are held
        against.

    Returns
    -------
    dict of str to list of float
        By model, in the order of `MEASURES`.
    """
    first = next(iter(found.values()))
    return {
        label: [
            1e6 * c["thinnest"].min(),
            1e6 * np.sqrt(np.mean(distance(c, first)[1] ** 2)),
            c["load"].mean(),
            np.abs(c["friction"]).mean(),
            c["power"].mean(),
            summaries[label]["mean_iterations"],
            summaries[label]["max_iterations"],
            summaries[label]["wall_time_s"],
        ]
        for label, c in found.items()
    }


def draw_rivals(found, iterations, path):
    """Thinnest film, distance from the first film, load, friction and iterations over time, all
    models in each panel.

    Parameters
    ----------
    found : dict
        By model: `curves`.
    iterations : dict
        By model: instants [s] and iterations of each step.
    path : Path
        The PNG file.
    """
    labels = (
        "thinnest film [um]",
        "distance from the\nfirst film, rms [um]",
        "load [N]",
        "friction force [N]",
        "iterations",
    )
    figure, panels = plt.subplots(
        len(labels), 1, sharex=True, layout="constrained", figsize=(11, 2.0 * len(labels))
    )
    first = next(iter(found.values()))
    for colour, (label, c) in zip(PALETTE, found.items()):
        shared, apart = distance(c, first)
        for panel, time, values in (
            (panels[0], c["time"], 1e6 * c["thinnest"]),
            (panels[1], shared, 1e6 * apart),
            (panels[2], c["time"], c["load"]),
            (panels[3], c["time"], c["friction"]),
        ):
            panel.plot(1e3 * time, values, color=colour, lw=1.2, label=label)
        time, steps = iterations[label]
        panels[-1].plot(1e3 * time[1:], steps[1:], color=colour, lw=0.9, label=label)
    for panel, label in zip(panels, labels):
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
        panel.margins(x=0)
    panels[0].legend(frameon=False, fontsize="small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
    panels[-1].set_xlabel("time [ms]")
    figure.savefig(path, dpi=130)
    plt.close(figure)
