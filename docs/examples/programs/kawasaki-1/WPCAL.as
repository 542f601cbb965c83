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
; weld speed <= 8 mm/s
; air speed <= 100 mm/s
; DRY RUN: the arc stays off; ARC ON and ARC OFF are comments (--arc on makes
;   them instructions)
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
; the arc burns from ARC ON to ARC OFF
; seam -> name here
;   W1 -> W1: tee fillet, 8.0 mm, 1 line, 95 % error up to 0.227 mm
;   W2 -> W2: tee fillet, 150.0 mm, 1 line, 95 % error up to 0.265 mm
;   W3 -> W3: tee fillet, 150.0 mm, 1 line, 95 % error up to 0.259 mm
;   W4 -> W4: tee fillet, 8.0 mm, 1 line, 95 % error up to 0.265 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 5 ALWAYS
  JMOVE wp_safe
  BREAK
  CALL weld_W1
  CALL weld_W2
  CALL weld_W3
  CALL weld_W4
  BASE wp_part
  SPEED 100 MM/S ALWAYS
  LMOVE wp_safe
  BREAK
  BASE NULL
.END
.PROGRAM weld_W1()
; W1
; tee fillet, 8.0 mm, 1 line, 95 % error up to 0.227 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 100 MM/S ALWAYS
  LMOVE W1_to01
  BREAK
  LMOVE W1_appr
  BREAK
  LMOVE W1_0001
  BREAK
; ARC ON
  SPEED 8 MM/S ALWAYS
  LMOVE W1_0002
  BREAK
; ARC OFF
  SPEED 100 MM/S ALWAYS
  LMOVE W1_retr
  BREAK
  LMOVE W1_up01
  BREAK
.END
.PROGRAM weld_W2()
; W2
; tee fillet, 150.0 mm, 1 line, 95 % error up to 0.265 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 100 MM/S ALWAYS
  LMOVE W2_to01
  BREAK
  LMOVE W2_to02
  BREAK
  LMOVE W2_to03
  BREAK
  LMOVE W2_appr
  BREAK
  LMOVE W2_0001
  BREAK
; ARC ON
  SPEED 8 MM/S ALWAYS
  LMOVE W2_0002
  BREAK
; ARC OFF
  SPEED 100 MM/S ALWAYS
  LMOVE W2_retr
  BREAK
  LMOVE W2_up01
  BREAK
.END
.PROGRAM weld_W3()
; W3
; tee fillet, 150.0 mm, 1 line, 95 % error up to 0.259 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 100 MM/S ALWAYS
  LMOVE W3_to01
  BREAK
  LMOVE W3_to02
  BREAK
  LMOVE W3_to03
  BREAK
  LMOVE W3_appr
  BREAK
  LMOVE W3_0001
  BREAK
; ARC ON
  SPEED 8 MM/S ALWAYS
  LMOVE W3_0002
  BREAK
; ARC OFF
  SPEED 100 MM/S ALWAYS
  LMOVE W3_retr
  BREAK
  LMOVE W3_up01
  BREAK
.END
.PROGRAM weld_W4()
; W4
; tee fillet, 8.0 mm, 1 line, 95 % error up to 0.265 mm
  BASE wp_part
  TOOL torch
  CP ON
  ACCURACY 1 ALWAYS
  SPEED 100 MM/S ALWAYS
  LMOVE W4_to01
  BREAK
  LMOVE W4_to02
  BREAK
  LMOVE W4_to03
  BREAK
  LMOVE W4_appr
  BREAK
  LMOVE W4_0001
  BREAK
; ARC ON
  SPEED 8 MM/S ALWAYS
  LMOVE W4_0002
  BREAK
; ARC OFF
  SPEED 100 MM/S ALWAYS
  LMOVE W4_retr
  BREAK
  LMOVE W4_up01
  BREAK
  LMOVE W4_up02
  BREAK
  LMOVE W4_up03
  BREAK
.END
.TRANS
wp_part 812.49820 -240.21072 155.80506 -117.245890 2.301941 151.604841
wp_safe 105.25257 62.83948 153.53784 0.000000 135.000000 90.000000
W1_to01 -6.38703 58.14522 157.57535 0.000000 135.000000 90.000000
W1_appr -10.35534 56.00000 45.35534 0.000000 135.000000 90.000000
W1_0001 25.00000 56.00000 10.00000 0.000000 135.000000 90.000000
W1_0002 25.00000 64.00000 10.00000 0.000000 135.000000 90.000000
W1_retr -10.35534 64.00000 45.35534 0.000000 135.000000 90.000000
W1_up01 -6.39243 66.14230 157.42267 0.000000 135.000000 90.000000
W2_to01 5.38772 51.68784 157.28242 28.016946 143.522671 147.957387
W2_to02 17.16787 37.23338 157.14217 61.983053 143.522671 -147.957388
W2_to03 28.94803 22.77892 157.00191 90.000000 135.000000 -90.000000
W2_appr 25.00000 20.64466 45.35534 90.000000 135.000000 -90.000000
W2_0001 25.00000 56.00000 10.00000 90.000000 135.000000 -90.000000
W2_0002 175.00000 56.00000 10.00000 90.000000 135.000000 -90.000000
W2_retr 175.00000 20.64466 45.35534 90.000000 135.000000 -90.000000
W2_up01 178.76076 22.67768 151.70620 90.000000 135.000000 -90.000000
W3_to01 128.80548 48.93875 152.97070 90.000000 165.000000 -90.000000
W3_to02 78.85019 75.19981 154.23519 -90.000000 165.000000 90.000000
W3_to03 28.89491 101.46088 155.49969 -90.000000 135.000000 90.000000
W3_appr 25.00000 99.35534 45.35534 -90.000000 135.000000 90.000000
W3_0001 25.00000 64.00000 10.00000 -90.000000 135.000000 90.000000
W3_0002 175.00000 64.00000 10.00000 -90.000000 135.000000 90.000000
W3_retr 175.00000 99.35534 45.35534 -90.000000 135.000000 90.000000
W3_up01 178.70764 101.35964 150.20398 -90.000000 135.000000 90.000000
W4_to01 190.48779 86.90518 150.06373 -118.016947 143.522671 32.042612
W4_to02 202.26795 72.45072 149.92347 -151.983054 143.522671 -32.042613
W4_to03 214.04810 57.99626 149.78322 180.000000 135.000000 -90.000000
W4_appr 210.35534 56.00000 45.35534 180.000000 135.000000 -90.000000
W4_0001 175.00000 56.00000 10.00000 180.000000 135.000000 -90.000000
W4_0002 175.00000 64.00000 10.00000 180.000000 135.000000 -90.000000
W4_retr 210.35534 64.00000 45.35534 180.000000 135.000000 -90.000000
W4_up01 214.04270 65.99334 149.63054 180.000000 135.000000 -90.000000
W4_up02 177.77932 64.94205 150.93297 180.000000 165.000000 -90.000000
W4_up03 141.51595 63.89076 152.23541 0.000000 165.000000 90.000000
.END
