MODULE WPCAL_touch
  ! written by wpcal 0.1.1 from the plan in touches.json, fingerprint
  !   0a9153c0
  ! part tee.step: 2 searches, wire 1.2 mm, stick-out 15 mm
  ! the tool centre point is the tip of the wire
  ! SAFETY: contact turns diTouch on. Before the first run hold the wire
  !   against the part by hand and see it turn on: without it the torch
  !   drives 16 mm on, into the part
  ! SAFETY: during searches the sensing voltage is on the wire: keep away
  !   from wire and torch
  ! SAFETY: after a missed search the part may be elsewhere. The program
  !   stops and names the search: look at the part before you start it
  !   again. It then goes on with the next search; after 2 misses it ends
  ! the way to the start of a search is sensed as well, at 30 mm/s
  ! NOT CHECKED: the arm, fixtures, cables, the way to the first point. RUN
  !   IT DRY FIRST
  ! run it dry: without the part, every search is missed (most_misses).
  !   Searches 10 mm/s, air 100 mm/s
  ! results: module WPCAL_touch_res, which must be loaded too; saved as
  !   HOME:/WPCAL_touch_res.mod
  ! targets and results are relative to wpPart, the part as planned; mm;
  !   q1..q4 = w,x,y,z
  ! confdata is not known: ConfJ, ConfL \Off let the controller choose, and
  !   are On again at the end
  ! run the procedure run_WPCAL_touch; tool tTorch must be declared on the
  !   controller
  ! search: what it touches, stroke and direction in the part
  !   T1: plane, end of the wire, 16.0 mm along (0.00 0.00 -1.00)
  !   T4: plane, side of the wire, 16.0 mm along (0.00 1.00 0.00)
  LOCAL PERS wobjdata wpPart:=[FALSE,TRUE,"",[[812.00000,-240.00000,156.00000],[0.955090735,0.014722824,-0.013761999,0.295627355]],[[0,0,0],[1,0,0,0]]];
  LOCAL VAR num wptMisses:=0;
  LOCAL CONST speeddata wptAir:=[100,500,100,500];
  LOCAL CONST speeddata wptSearch:=[10,500,10,500];
  LOCAL CONST speeddata wptNear:=[30,500,30,500];
  LOCAL CONST robtarget wptT1_A:=[[40.00000,100.00000,115.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT1_S:=[[40.00000,100.00000,18.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT1_E:=[[40.00000,100.00000,2.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT1_R:=[[40.00000,100.00000,115.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT4_A:=[[40.00000,-8.60000,115.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT4_S:=[[40.00000,-8.60000,5.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT4_E:=[[40.00000,7.40000,5.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget wptT4_R:=[[40.00000,-8.60000,115.00000],[0.000000000,1.000000000,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];

  LOCAL PROC touch_T1()
    ConfJ\Off;
    ConfL\Off;
    MoveJ wptT1_A,v100,fine,tTorch\WObj:=wpPart;
    wptTouch wptT1_S,wptT1_E,wptO_T1,wptP_T1;
    IF wptO_T1=3 THEN
    MoveL wptT1_A,wptAir,fine,tTorch\WObj:=wpPart;
    ELSE
    MoveL wptT1_S,wptAir,fine,tTorch\WObj:=wpPart;
    MoveL wptT1_R,wptAir,fine,tTorch\WObj:=wpPart;
    ENDIF
    IF wptO_T1<>1 wptTell "T1",wptO_T1;
    ConfJ\On;
    ConfL\On;
  ENDPROC

  LOCAL PROC touch_T4()
    ConfJ\Off;
    ConfL\Off;
    MoveL wptT4_A,wptAir,fine,tTorch\WObj:=wpPart;
    wptTouch wptT4_S,wptT4_E,wptO_T4,wptP_T4;
    IF wptO_T4=3 THEN
    MoveL wptT4_A,wptAir,fine,tTorch\WObj:=wpPart;
    ELSE
    MoveL wptT4_S,wptAir,fine,tTorch\WObj:=wpPart;
    MoveL wptT4_R,wptAir,fine,tTorch\WObj:=wpPart;
    ENDIF
    IF wptO_T4<>1 wptTell "T4",wptO_T4;
    ConfJ\On;
    ConfL\On;
  ENDPROC

  LOCAL PROC wptTouch(robtarget pStart,robtarget pEnd,PERS num outcome,PERS robtarget place)
    VAR robtarget pHit;
    VAR num nOutcome:=1;
    IF diTouch=high THEN
      nOutcome:=3;
    ELSE
      nOutcome:=3;
      SearchL\Stop,diTouch,pHit,pStart,wptNear,tTorch\WObj:=wpPart;
      IF nOutcome=1 SearchL\Stop,diTouch,pHit,pEnd,wptSearch,tTorch\WObj:=wpPart;
      WaitTime 0.1;
    ENDIF
    IF nOutcome=1 place:=pHit;
    outcome:=nOutcome;
  ERROR
    IF ERRNO=ERR_WHLSEARCH THEN
      IF nOutcome=1 THEN
        nOutcome:=2;
      ELSE
        nOutcome:=1;
      ENDIF
      TRYNEXT;
    ELSEIF ERRNO=ERR_SIGSUPSEARCH THEN
      nOutcome:=3;
      StopMove;
      ClearPath;
      StartMove;
      TRYNEXT;
    ENDIF
  ENDPROC

  PROC run_WPCAL_touch()
    wptClear;
    touch_T1;
    touch_T4;
    wptSave;
  ENDPROC

  LOCAL PROC wptClear()
    wptO_T1:=0;
    wptO_T4:=0;
    wptMisses:=0;
    wptPlan:="0a9153c0";
    wptTool:="tTorch";
    wptCount:=2;
    wptPart:=wpPart;
  ENDPROC

  LOCAL PROC wptTell(string name,num outcome)
    wptSave;
    wptMisses:=wptMisses+1;
    IF outcome=3 THEN
      TPWrite name+" signal on at start";
    ELSE
      TPWrite name+" missed: look at the part";
    ENDIF
    IF wptMisses>=2 THEN
      TPWrite "2 misses: program ends";
      EXIT;
    ENDIF
    Stop;
  ENDPROC

  LOCAL PROC wptSave()
    Save "WPCAL_touch_res"\FilePath:="HOME:"\File:="WPCAL_touch_res.mod";
  ERROR
    TPWrite "results not saved; they are in WPCAL_touch_res";
    TRYNEXT;
  ENDPROC
ENDMODULE
