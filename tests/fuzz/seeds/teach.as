.PROGRAM teach() #1
  BASE fix
  TOOL torch
  LMOVE v1
  JMOVE v2 ;corner
  BASE NULL
  C1MOVE v3
  C2MOVE fix + v4
  POINT p = TRANS(1, 2, 3, 0, 180, 0)
.END
.TRANS
fix 100.0 0.0 0.0 90.0 0.0 0.0
v1 812.3 -4.25 100.0 0.0 180.0 -90.0
v2 1 2 3 4 5 6
v3 7 8 9 0 180 0 0 180
v4[1,2] 1 2 3 0 180 0
.END
.JOINTS
#home 0 10 -20 0 90 0
.END
