"""Sample parts with known seams and a known pose: small ones (`parts`) and one of any size (`steel_structure`)."""
