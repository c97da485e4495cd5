"""Make the meshes piston.msh.xz and block.msh.xz of this case next to this script.

It needs gmsh, which running the case does not:

python -m piston_cosim.models.numerical_example.make_meshes
"""

from pathlib import Path

from ..meshes import Block, Piston, make

PISTON = Piston(
    skirt_radius=28.225,  # 25 um nominal radial clearance
    land_radius=28.05,
    skirt=(-16.0, 11.0),
    top=26.0,
    crown=5.0,
    skirt_inside=(26.5, 26.0),
    belt_inside=23.0,
    pin=7.0,
    boss=11.5,
    boss_from=9.0,
    boss_length=22.0,
    pillar_width=15.0,
    pillar_from=11.0,
    pillar_length=20.0,
    reach=27.0,
    root=3.0,
)
BLOCK = Block(
    bore=28.25,
    wall=7.0,  # 56.5 mm bore, the published 124 cm3 single
    ends=(56.25, 151.25),  # 95 mm inside, crown 0.5 mm below the deck at top dead centre
    flange=43.0,
    flange_thickness=10.0,
    fins=(82.0, 102.0, 122.0),
    fin_radius=47.0,
    fin_thickness=4.0,
    stud=31.5,
    stud_hole=4.5,
    seat=9.0,
)

if __name__ == "__main__":
    make(Path(__file__).with_name("piston.msh.xz"), PISTON, 3.9, 12)
    make(Path(__file__).with_name("block.msh.xz"), BLOCK, 9.0, 10)
