"""Film balance: film thickness to pressure, one time step.

films        what a film thickness means for flow and shear (E); flow_film: for any oil and surface
reynolds     balance on faces and cells, and its five-point matrix (E); tangent: its derivatives
storage      oil content, second order in time (T)
transport    sharp oil fronts (T)
oil_layer    oil on the bore (T)
openings     cells without a film
film_step    one step of the balance; coated_film: under a coating
"""
