"""Gallery of the shipped cases: a picture, a number next to another one, and the run time of each.

`python docs/gallery.py [CASE ...]` runs the cases and writes `gallery.json`, which the build of the
site reads. A second call measures the run times without compiling and without reducing bodies.
"""

import json
import math
import resource
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
TABLE = ROOT / "docs" / "gallery.toml"
MEASURED = ROOT / "docs" / "gallery.json"


def cases():
    """Return the names of the shipped cases in the order of the gallery."""
    return list(tomllib.loads(TABLE.read_text()))


def studies():
    """Return the names of the comparisons with published studies."""
    return sorted(path.parent.name for path in (ROOT / "models/measured").glob("*/README.md"))


def measured():
    """Return case -> variant -> its summary and its processor time."""
    return json.loads(MEASURED.read_text()) if MEASURED.exists() else {}


def number(case):
    """Return the number of a case and the one next to it, both in the unit of the table."""
    from piston_cosim.master.fmi.quantities import from_si

    entry = tomllib.loads(TABLE.read_text())[case]
    key, unit = entry["key"], entry["unit"]
    reference = entry.get("reference") or entry["compared"]
    runs = measured()

    def shown(value):
        return from_si(value, SI[unit], unit) if unit else float(value)

    value = shown(runs[case][entry["variants"][0]][key])
    if "value" in reference:
        other = float(reference["value"].split()[0])
    elif "closed_form" in reference:
        other = shown(CLOSED_FORMS[reference["closed_form"]]())
    elif "variant" in reference:
        other = shown(runs[case][reference["variant"]][key])
    else:
        variants = runs[reference["case"]]
        other = shown(next(iter(variants.values()))[reference.get("key", key)])
    return value, other


SI = {"um": "m", "m": "m", "deg": "rad", "kN": "N", "MPa": "Pa", "W": "W"}
"""Unit of the table -> unit of the summary."""


# ---- closed forms


def parameters(case, participant):
    """Return the parameters of a participant in SI units, and the mass of a rigid piston."""
    from piston_cosim.master.fmi.quantities import registry

    tree = tomllib.loads((ROOT / "models" / case / "case.toml").read_text())
    table = tree["participants"][participant]
    quantity = registry().Quantity
    values = {
        name: quantity(text).to_base_units().magnitude
        for name, text in table["parameters"].items()
        if isinstance(text, str) and text[:1].isdigit()
    }
    piston = table.get("build", {}).get("piston", {}).get("rigid")
    return values | ({"piston_mass": quantity(piston["mass"]).magnitude} if piston else {})


def petroff():
    """Return the friction power of a concentric journal: P = 2 pi mu w^2 R^3 L / C."""
    shaft, film = parameters("journal_bearing", "shaft"), parameters("journal_bearing", "film")
    factor = 2.0 * math.pi * film["viscosity"] * shaft["speed"] ** 2
    return factor * shaft["radius"] ** 3 * film["skirt_length"] / shaft["clearance"]


def shaking_force():
    """Return the second order of the upward force of two slider-cranks 180 degrees apart.

    F = -2 m r w^2 (s + s^3/4 + 15 s^5/128) with s = r/L
    """
    of = parameters("twin", "front")
    ratio = of["crank_radius"] / of["rod_length"]
    mass = of["piston_mass"] + of["pin_mass"]
    mass += of["rod_mass"] * of["rod_centre"] / of["rod_length"]
    series = ratio + ratio**3 / 4.0 + 15.0 * ratio**5 / 128.0
    return -2.0 * mass * of["crank_radius"] * of["crank_speed"] ** 2 * series


def side_force():
    """Return the largest side force of the slider-crank of `data_sheet`.

    F = (p A - m a) tan psi, with the mass of piston and pin, and the reciprocating share of the rod
    at the pin.
    """
    of = parameters("data_sheet", "bodies")
    bore = parameters("data_sheet", "ehd")["bore_radius"]
    radius, length, speed = of["crank_radius"], of["rod_length"], of["crank_speed"]
    mass = of["piston_mass"] + of["pin_mass"]
    mass += of["rod_mass"] * of["rod_centre"] / length
    rows = (ROOT / "models/data_sheet/gas_pressure.csv").read_text().split("\n")
    forces = []
    for row in rows:
        try:
            degrees, pressure = (float(cell) for cell in row.split(","))
        except ValueError:
            continue
        sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
        depth = math.sqrt(length**2 - (radius * sine) ** 2)
        swing = radius**2 * (cosine**2 - sine**2) / depth + (radius**2 * sine * cosine) ** 2 / (
            depth**3
        )
        acceleration = -(speed**2) * (radius * cosine + swing)
        axial = 1e6 * pressure * math.pi * bore**2 + mass * acceleration
        forces.append(abs(axial * radius * sine / depth))
    return max(forces)


CLOSED_FORMS = {"petroff": petroff, "shaking_force": shaking_force, "side_force": side_force}


# ---- the page

DESIGN = (
    "![Maps of the skirt: change of eight figures by a micrometre on a hundredth of the skirt]"
    "(how_to/design_maps.png)",
    "",
    "The [maps of sensitivities](how_to/design.md) show what a figure gains if the skirt is "
    "further from the bore there. In numerical_example, a flatter barrel (middle further from the "
    "bore, edges closer) gives a thicker film, less pressure and less friction.",
)
"""Lines about the maps of the page of designs, whose first command draws them."""


def page():
    """Return the page of the gallery as Markdown."""
    lines = [
        "# Gallery",
        "",
        "Each shipped case has a picture, one number and its run time. A reference is an "
        "independent value of the same quantity. Other numbers are compared with another run or "
        "engine. The run time is processor time on one core, with compiled kernels and reduced "
        "bodies in the cache. The machine had other work. `python docs/gallery.py` runs the cases "
        "and writes the numbers. The page of the case shows the command that draws its picture.",
        "",
        '<div class="gallery">',
    ]
    for case, entry in tomllib.loads(TABLE.read_text()).items():
        value, reference = number(case)
        first = measured()[case][entry["variants"][0]]
        kind = "reference" if "reference" in entry else "compared"
        unit, source = entry["unit"], entry[kind]["source"]
        words = {"reference": "reference", "compared": "compared with"}[kind]
        text = (ROOT / "models" / case / "case.toml").read_text()
        title = tomllib.loads(text)["title"]
        image, caption = picture(case)
        lines.append(
            f'<figure><a href="../cases/{case}/"><img src="../pictures/models/{image}" '
            f'alt="{caption}" loading="lazy"></a><figcaption>'
            f'<a href="../cases/{case}/"><strong>{case}</strong></a><br>{title}'
            f"<ul><li>{entry['quantity']}: {value:.3g} {unit}</li>"
            f"<li>{words}: {reference:.3g} {unit}, {source}</li>"
            f"<li>run time: {first['processor_time_s']:.2g} s</li></ul>"
            f"<code>piston-cosim run {case} --only {entry['variants'][0]}</code>"
            "</figcaption></figure>"
        )
    lines += ["</div>", "", "## Where a profile matters", "", *DESIGN, ""]
    lines += ["## Published studies", "", '<div class="gallery">']
    for study in studies():
        if (shown := picture(f"measured/{study}")) is not None:
            lines.append(
                f'<figure><a href="../studies/{study}/"><img src="../pictures/models/{shown[0]}" '
                f'alt="{shown[1]}" loading="lazy"></a><figcaption>'
                f'<a href="../studies/{study}/"><strong>{study}</strong></a><br>{shown[1]}'
                "</figcaption></figure>"
            )
    return "\n".join([*lines, "</div>", ""])


def picture(case):
    """Return path and caption of the first picture of the page of a case, None without one."""
    import re

    text = (ROOT / "models" / case / "README.md").read_text()
    match = re.search(r"!\[([^\]]*)\]\(([^)]+\.png)\)", text)
    if match is None:
        return None
    path = (ROOT / "models" / case / match[2]).resolve()
    return path.relative_to((ROOT / "models").resolve()).as_posix(), match[1]


# ---- measuring


def measure(names):
    """Run cases and write their summaries and processor times."""
    runs = measured()
    for case, entry in tomllib.loads(TABLE.read_text()).items():
        if names and case not in names:
            continue
        runs[case] = {variant: run(case, variant, entry) for variant in entry["variants"]}
        ordered = {name: runs[name] for name in cases() if name in runs}
        MEASURED.write_text(json.dumps(ordered, indent=1) + "\n")


def run(case, variant, entry):
    """Run one variant and return its summary without times, and its processor time."""
    changes = []
    if "summary" in entry:
        changes = ["--set", f'summary.{entry["key"]}="{entry["summary"]}"']
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "piston_cosim", "run", case, "--only", variant]
        command += ["--no-plots", "--summary-json", "summary.json", *changes]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        summary = json.loads((Path(folder) / "summary.json").read_text())
    times = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    kept = {
        key: value
        for key, value in summary.items()
        if not (key.startswith(("wall_time", "variants")) or key == "first_step_after_s")
    }
    return {"processor_time_s": round(times, 2)} | kept


if __name__ == "__main__":
    measure(sys.argv[1:])
