"""Flexible bodies: piston and block reduced from finite elements, on a rigid slider-crank.

Its subpackages:

    finite_elements  meshes, surfaces, matrices, the ten-node tetrahedron, sparse solvers
    reduction        from a mesh or matrices to a small exact body: bases, grid, tables and pictures
                     of modes
    geometry         skirt and bore as the film sees them: profiles, film thickness, forces back by
                     virtual work
    dynamics         equations of motion, their time integration, and the model that composes all
    monoblock        a flexible block of several cylinders, a separate FMU
    shell            an elastic shell of a bearing, a separate FMU

The FMU: options (the case's build table, validated), build, variables, slave; what the running FMU
reads is declared in dynamics (build_options, parameters) and reduction (reduced_body). Bodies
without an FMU: offline. A measured profile without a case: profile_reader.
"""
