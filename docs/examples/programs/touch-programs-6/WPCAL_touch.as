.PROGRAM WPCAL_touch()
; written by wpcal 0.1.1 from the plan in touches.json, fingerprint 0a9153c0
; part tee.step: 2 searches, wire 1.2 mm, stick-out 15 mm
; the tool centre point is the tip of the wire
; SAFETY: contact turns signal 1001 on. Before the first run hold the wire
;   against the part by hand and see it turn on: without it the torch drives
;   16 mm on, into the part
; SAFETY: during searches the sensing voltage is on the wire: keep away from
;   wire and torch
; SAFETY: after a missed search the part may be elsewhere. The program stops
;   and names the search: look at the part before you start it again. It then
;   goes on with the next search; after 2 misses it ends
; the way to the start of a search is sensed as well, at 30 mm/s
; NOT CHECKED: the arm, fixtures, cables, the way to the first point. RUN IT
;   DRY FIRST
; run it dry: without the part, every search is missed (most_misses). Searches
;   10 mm/s, air 100 mm/s
; results: variables wpto_, wptp_ and $wpt_plan: SAVE them into a file on the
;   controller and copy it
; points and results are relative to wpt_part, the part as planned; mm; R =
;   Rz(O) Ry(A) Rz(T), deg
; the configuration is not known: the arm keeps the one it comes with
; the transformation tTorch (the torch) must be on the controller
; search: what it touches, stroke and direction in the part
;   T1: plane, end of the wire, 16.0 mm along (0.00 0.00 -1.00)
;   T4: plane, side of the wire, 16.0 mm along (0.00 1.00 0.00)
  BASE wpt_part
  TOOL tTorch
  CP ON
  ACCURACY 1 ALWAYS
  $wpt_plan = "0a9153c0"
  $wpt_tool = "tTorch"
  wpt_count = 2
  wpt_misses = 0
  wpto_t1 = 0
  wpto_t4 = 0
; T1
  SPEED 5 ALWAYS
  JMOVE wpt_t1a
  BREAK
  wpt_outcome = 2
  SPEED 30 MM/S ALWAYS
  IF NOT SIG(1001) THEN
    XMOVE wpt_t1s TILL 1001
    BREAK
  END
  IF SIG(1001) THEN
    wpt_outcome = 3
  ELSE
  SPEED 10 MM/S ALWAYS
    XMOVE wpt_t1e TILL 1001
    BREAK
    IF SIG(1001) THEN
      HERE wptp_t1
      wpt_outcome = 1
    END
    TWAIT 0.1
  END
  wpto_t1 = wpt_outcome
  IF wpt_outcome == 3 THEN
  SPEED 100 MM/S ALWAYS
  LMOVE wpt_t1a
  BREAK
    PRINT "T1 signal on at start"
  ELSE
  LMOVE wpt_t1s
  BREAK
  LMOVE wpt_t1r
  BREAK
  END
  IF wpt_outcome == 2 THEN
    PRINT "T1 missed: look at the part"
  END
  IF wpt_outcome <> 1 THEN
    wpt_misses = wpt_misses + 1
    IF wpt_misses >= 2 THEN
      PRINT "2 misses: program ends"
      HALT
    END
    PAUSE
  END
; T4
  LMOVE wpt_t4a
  BREAK
  wpt_outcome = 2
  SPEED 30 MM/S ALWAYS
  IF NOT SIG(1001) THEN
    XMOVE wpt_t4s TILL 1001
    BREAK
  END
  IF SIG(1001) THEN
    wpt_outcome = 3
  ELSE
  SPEED 10 MM/S ALWAYS
    XMOVE wpt_t4e TILL 1001
    BREAK
    IF SIG(1001) THEN
      HERE wptp_t4
      wpt_outcome = 1
    END
    TWAIT 0.1
  END
  wpto_t4 = wpt_outcome
  IF wpt_outcome == 3 THEN
  SPEED 100 MM/S ALWAYS
  LMOVE wpt_t4a
  BREAK
    PRINT "T4 signal on at start"
  ELSE
  LMOVE wpt_t4s
  BREAK
  LMOVE wpt_t4r
  BREAK
  END
  IF wpt_outcome == 2 THEN
    PRINT "T4 missed: look at the part"
  END
  IF wpt_outcome <> 1 THEN
    wpt_misses = wpt_misses + 1
    IF wpt_misses >= 2 THEN
      PRINT "2 misses: program ends"
      HALT
    END
    PAUSE
  END
  BASE NULL
.END
.TRANS
wpt_part 812.00000 -240.00000 156.00000 -115.869320 2.309551 150.266844
wpt_t1a 40.00000 100.00000 115.00000 180.000000 180.000000 0.000000
wpt_t1s 40.00000 100.00000 18.00000 180.000000 180.000000 0.000000
wpt_t1e 40.00000 100.00000 2.00000 180.000000 180.000000 0.000000
wpt_t1r 40.00000 100.00000 115.00000 180.000000 180.000000 0.000000
wpt_t4a 40.00000 -8.60000 115.00000 180.000000 180.000000 0.000000
wpt_t4s 40.00000 -8.60000 5.00000 180.000000 180.000000 0.000000
wpt_t4e 40.00000 7.40000 5.00000 180.000000 180.000000 0.000000
wpt_t4r 40.00000 -8.60000 115.00000 180.000000 180.000000 0.000000
.END
