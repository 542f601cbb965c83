"""Plates that moved, from arrays: which touches to make, the fit, and the error that remains. Lengths in mm."""

import numpy as np

import wpcal

up, out, end = [0, 0, 1], [0, -1, 0], [-1, 0, 0]
places = [  # where, outward normal, body
    *(([x, y, 10], up, "plate") for x in (20, 100, 180) for y in (20, 100)),
    *(([x, 0, 5], out, "plate") for x in (20, 180)),
    ([0, 60, 5], end, "plate"),
    *(([x, 56, z], out, "web") for x in (35, 165) for z in (20, 80)),
    ([25, 60, 50], end, "web"),
]
p, n, body = zip(*places, strict=True)
seam = [[25, 56, 10], [100, 56, 10], [175, 56, 10]]
faces = ([out] * 3, [up] * 3)
advice = wpcal.advise_touches(p, n, body, seam, faces, (["web"] * 3, ["plate"] * 3), count=8, sigma_mm=0.1)
for touch in advice.touches:
    print(touch.name, touch.where, "for", touch.seam)
print(f"predicted 95 % error: {advice.error_95_mm:.2f} mm")

# all places touched; the web is 1.5 mm further along -y than in the model
is_web = np.array([[name == "web"] for name in body])
p_base = np.array(p) + np.array([800.0, -200.0, 150.0])
p_base += is_web * np.array([0.0, -1.5, 0.0])
found = wpcal.calibrate_bodies(p, n, p_base, body, sigma_mm=0.1)
print(found.sentence())
for name, v in zip(found.fit.motions.bodies.names, found.fit.motions.v_mm.round(2).tolist(), strict=True):
    print(f"{name} moved by {v} mm within the part")
print(f"the web's corner is known to {wpcal.predict_body_errors(found, [[25, 56, 10]], ['web'])[0]:.2f} mm (95 %)")
