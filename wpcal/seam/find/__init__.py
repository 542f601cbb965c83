"""Where members meet: contacts, concave edges, interpenetrations, marked edges, beads."""
