.PROGRAM WPCAL()
; written by wpcal 0.1.1 from calibration.json and seams.json
; calibration PASS, tolerance 0.5 mm
; the 4 accepted seams are within 0.284 mm with 95 % confidence (teaching
;   error 0.094 mm per axis, estimated from the residuals with 6 degrees of
;   freedom; robot 0.25 mm per axis over 686 mm, assumed: uncalibrated six-
;   axis arm); the tolerance is 0.5 mm
; wire leaves the tip along +z of the tool, z_sense inward
; work angle 0 deg, travel 0 deg (+ push)
; turn about the wire: as few moves need it, within 180 deg of the travel
;   direction
; tool centre point 0 mm back from the tip, approach 50 mm, retract 50 mm
; lines and arcs: the wire is at most 0.000 mm and 0.00 deg off (allowed: 0.05
;   mm, 0.5 deg)
; weld speed <= 6.3 mm/s
; air speed <= 100 mm/s
; the arc burns from SEAM START to SEAM END: RUN IT with the arc blocked at
;   the controller FIRST
; checked against the part, to 0.05 mm: a straight torch of 300 mm, nozzle
;   radius 11 mm, wire 20 mm
; between seams the tool goes 61 mm above the part, 3 mm from it at least
; NOT CHECKED: the arm, fixtures, cables, the way to the first point. RUN IT
;   DRY FIRST
; points are relative to wp_part, the part as calibrated; mm; R = Rz(O) Ry(A)
;   Rz(T), deg
; written with 5 and 6 decimals: within 0.00001 mm and 0.000001 deg
; the configuration is not known: the arm keeps the one it comes with
; the transformation torch (the torch) must be on the controller
; W1SET and W2SET replace weld conditions of the controller: 1
; gas, and the delay before the torch moves, are those of the controller
; seam -> name here
;   W2 -> W2: z6.5 fillet weld, process 135, PB, 290 A, 30.5 V, 7.4 m/min
;   wire, 6.3 mm/s, tee fillet, 150.0 mm, 1 line, 95 % error up to 0.265 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 5 ALWAYS
  JMOVE wp_safe
  BREAK
  CALL weld_W2
  BASE wp_part
  SPEED 100 MM/S ALWAYS
  LMOVE wp_safe
  BREAK
  BASE NULL
.END
.PROGRAM weld_W2()
; W2
; z6.5 fillet weld, process 135, PB, 290 A, 30.5 V, 7.4 m/min wire, 6.3 mm/s,
;   tee fillet, 150.0 mm, 1 line, 95 % error up to 0.265 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 100 MM/S ALWAYS
  LMOVE W2_to01
  BREAK
  LMOVE W2_appr
  BREAK
; SEAM START
  W1SET 1 = 37.8,290,30.5,3.0,2.1
  W2SET 1 = 0.70,290,30.5
  LWS W2_0001
  LWE W2_0002 ,1,1
; SEAM END
  LMOVE W2_retr
  BREAK
  LMOVE W2_up01
  BREAK
.END
.TRANS
wp_part 812.49820 -240.21072 155.80506 -117.245890 2.301941 151.604841
wp_safe 105.25257 62.83948 153.53784 90.000000 135.000000 -90.000000
W2_to01 28.94803 22.77892 157.00191 90.000000 135.000000 -90.000000
W2_appr 25.00000 20.64466 45.35534 90.000000 135.000000 -90.000000
W2_0001 25.00000 56.00000 10.00000 90.000000 135.000000 -90.000000
W2_0002 175.00000 56.00000 10.00000 90.000000 135.000000 -90.000000
W2_retr 175.00000 20.64466 45.35534 90.000000 135.000000 -90.000000
W2_up01 178.76076 22.67768 151.70620 90.000000 135.000000 -90.000000
.END
