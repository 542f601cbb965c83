"""The judge of finished programs: what their text makes a robot do, compared with the part and with what was asked."""
