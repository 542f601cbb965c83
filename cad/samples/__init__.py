"""Sample parts with known seams and a known place."""
