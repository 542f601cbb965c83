MODULE WPCAL
  ! written by wpcal 0.1.1 from calibration.json and seams.json
  ! calibration PASS, tolerance 0.5 mm
  ! the 4 accepted seams are within 0.284 mm with 95 % confidence (teaching
  !   error 0.094 mm per axis, estimated from the residuals with 6 degrees
  !   of freedom; robot 0.25 mm per axis over 686 mm, assumed: uncalibrated
  !   six-axis arm); the tolerance is 0.5 mm
  ! wire leaves the tip along +z of the tool, z_sense inward
  ! work angle 0 deg, travel 0 deg (+ push)
  ! turn about the wire: as few moves need it, within 180 deg of the travel
  !   direction
  ! tool centre point 0 mm back from the tip, approach 50 mm, retract 50 mm
  ! lines and arcs: the wire is at most 0.000 mm and 0.00 deg off (allowed:
  !   0.05 mm, 0.5 deg)
  ! weld speed <= 6.3 mm/s
  ! air speed <= 100 mm/s
  ! the arc burns from SEAM START to SEAM END: RUN IT with the arc blocked
  !   at the controller FIRST
  ! checked against the part, to 0.05 mm: a straight torch of 300 mm, nozzle
  !   radius 11 mm, wire 20 mm
  ! between seams the tool goes 61 mm above the part, 3 mm from it at least
  ! NOT CHECKED: the arm, fixtures, cables, the way to the first point. RUN
  !   IT DRY FIRST
  ! targets are relative to wpPart, the part as calibrated; mm; q1..q4 =
  !   w,x,y,z
  ! written with 5 and 9 decimals: within 0.00001 mm and 0.000001 deg
  ! confdata is not known: ConfJ, ConfL \Off let the controller choose, and
  !   are On again at the end
  ! the tool, and data without sm_, wd_ and wv_, must be declared on the
  !   controller; wire feed in mm/s
  ! seam -> name here
  !   W2 -> W2: z6.5 fillet weld, process 135, PB, 290 A, 30.5 V, 7.4 m/min
  !   wire, 6.3 mm/s, tee fillet, 150.0 mm, 1 line, 95 % error up to 0.265
  !   mm
  PERS wobjdata wpPart:=[FALSE,TRUE,"",[[812.49820,-240.21072,155.80506],[0.955191470,0.014345299,-0.014060401,0.295306235]],[[0,0,0],[1,0,0,0]]];
  LOCAL CONST speeddata vWeld:=[8,500,8,500];
  LOCAL CONST speeddata vAir:=[100,500,100,500];
  LOCAL CONST speeddata v_W2:=[6.3,500,6.3,500];
  LOCAL PERS seamdata sm_W2:=[0,0.5,[0,0,0,0,0,0,0,0,0],0.2,0,0,0,0,[0,0,0,0,0,0,0,0,0],0,0.7,[0,0,0,0,0,0,0,0,0],0,0,[0,0,0,0,0,0,0,0,0],0.5];
  LOCAL PERS welddata wd_W2:=[6.3,0,[3,0,30.5,123.3,0,290,0,0,0],[0,0,0,0,0,0,0,0,0]];
  LOCAL CONST robtarget wpSafe:=[[105.25257,62.83948,153.53784],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_to01:=[[28.94803,22.77892,157.00191],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_appr:=[[25.00000,20.64466,45.35534],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_0001:=[[25.00000,56.00000,10.00000],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_0002:=[[175.00000,56.00000,10.00000],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_retr:=[[175.00000,20.64466,45.35534],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_up01:=[[178.76076,22.67768,151.70620],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];

  PROC weld_W2()
    ConfJ\Off;
    ConfL\Off;
    MoveL W2_to01,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_appr,vAir,fine,tTorch\WObj:=wpPart;
    ! SEAM START
    ArcLStart W2_0001,v_W2,sm_W2,wd_W2,fine,tTorch\WObj:=wpPart;
    ArcLEnd W2_0002,v_W2,sm_W2,wd_W2,fine,tTorch\WObj:=wpPart;
    ! SEAM END
    MoveL W2_retr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_up01,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC
  PROC run_WPCAL()
    ConfJ\Off;
    ConfL\Off;
    MoveJ wpSafe,v100,fine,tTorch\WObj:=wpPart;
    weld_W2;
    ConfJ\Off;
    ConfL\Off;
    MoveL wpSafe,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC
ENDMODULE
