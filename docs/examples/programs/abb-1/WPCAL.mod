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
  ! weld speed <= 8 mm/s
  ! air speed <= 100 mm/s
  ! DRY RUN: the arc stays off; ARC ON and ARC OFF are comments (--arc on
  !   makes them instructions)
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
  ! the tool must be declared on the controller; the arc burns from ARC ON
  !   to ARC OFF
  ! seam -> name here
  !   W1 -> W1: tee fillet, 8.0 mm, 1 line, 95 % error up to 0.227 mm
  !   W2 -> W2: tee fillet, 150.0 mm, 1 line, 95 % error up to 0.265 mm
  !   W3 -> W3: tee fillet, 150.0 mm, 1 line, 95 % error up to 0.259 mm
  !   W4 -> W4: tee fillet, 8.0 mm, 1 line, 95 % error up to 0.265 mm
  PERS wobjdata wpPart:=[FALSE,TRUE,"",[[812.49820,-240.21072,155.80506],[0.955191470,0.014345299,-0.014060401,0.295306235]],[[0,0,0],[1,0,0,0]]];
  LOCAL CONST speeddata vWeld:=[8,500,8,500];
  LOCAL CONST speeddata vAir:=[100,500,100,500];
  LOCAL CONST robtarget wpSafe:=[[105.25257,62.83948,153.53784],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W1_to01:=[[-6.38704,58.14522,157.57536],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W1_appr:=[[-10.35534,56.00000,45.35534],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W1_0001:=[[25.00000,56.00000,10.00000],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W1_0002:=[[25.00000,64.00000,10.00000],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W1_retr:=[[-10.35534,64.00000,45.35534],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W1_up01:=[[-6.39243,66.14230,157.42267],[0.270598050,0.653281483,0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_to01:=[[5.38772,51.68784,157.28242],[0.010992758,0.822270280,0.475307972,0.312782796],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_to02:=[[17.16787,37.23338,157.14217],[0.228943890,-0.917526381,-0.245339400,-0.213397783],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_to03:=[[28.94803,22.77892,157.00191],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_appr:=[[25.00000,20.64466,45.35534],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_0001:=[[25.00000,56.00000,10.00000],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_0002:=[[175.00000,56.00000,10.00000],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_retr:=[[175.00000,20.64466,45.35534],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_up01:=[[178.76076,22.67768,151.70620],[0.382683432,-0.923879532,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_to01:=[[128.80547,48.93875,152.97070],[0.130526192,-0.991444861,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_to02:=[[78.85019,75.19981,154.23519],[0.130526192,0.991444861,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_to03:=[[28.89490,101.46088,155.49969],[0.382683432,0.923879533,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_appr:=[[25.00000,99.35534,45.35534],[0.382683432,0.923879533,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_0001:=[[25.00000,64.00000,10.00000],[0.382683432,0.923879533,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_0002:=[[175.00000,64.00000,10.00000],[0.382683432,0.923879533,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_retr:=[[175.00000,99.35534,45.35534],[0.382683432,0.923879533,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W3_up01:=[[178.70764,101.35964,150.20398],[0.382683432,0.923879533,0.000000000,0.000000000],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_to01:=[[190.48779,86.90518,150.06373],[0.228943890,0.917526381,0.245339400,-0.213397783],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_to02:=[[202.26795,72.45072,149.92347],[0.010992758,-0.822270280,-0.475307972,0.312782796],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_to03:=[[214.04810,57.99626,149.78322],[0.270598050,-0.653281483,-0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_appr:=[[210.35534,56.00000,45.35534],[0.270598050,-0.653281483,-0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_0001:=[[175.00000,56.00000,10.00000],[0.270598050,-0.653281483,-0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_0002:=[[175.00000,64.00000,10.00000],[0.270598050,-0.653281483,-0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_retr:=[[210.35534,64.00000,45.35534],[0.270598050,-0.653281483,-0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_up01:=[[214.04270,65.99334,149.63054],[0.270598050,-0.653281483,-0.653281482,0.270598050],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_up02:=[[177.77932,64.94205,150.93297],[0.092295956,-0.701057385,-0.701057384,0.092295955],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W4_up03:=[[141.51595,63.89076,152.23541],[0.092295956,0.701057385,0.701057384,0.092295956],[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];

  PROC weld_W1()
    ConfJ\Off;
    ConfL\Off;
    MoveL W1_to01,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W1_appr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W1_0001,vAir,fine,tTorch\WObj:=wpPart;
    ! ARC ON
    MoveL W1_0002,vWeld,fine,tTorch\WObj:=wpPart;
    ! ARC OFF
    MoveL W1_retr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W1_up01,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC

  PROC weld_W2()
    ConfJ\Off;
    ConfL\Off;
    MoveL W2_to01,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_to02,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_to03,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_appr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_0001,vAir,fine,tTorch\WObj:=wpPart;
    ! ARC ON
    MoveL W2_0002,vWeld,fine,tTorch\WObj:=wpPart;
    ! ARC OFF
    MoveL W2_retr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W2_up01,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC

  PROC weld_W3()
    ConfJ\Off;
    ConfL\Off;
    MoveL W3_to01,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W3_to02,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W3_to03,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W3_appr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W3_0001,vAir,fine,tTorch\WObj:=wpPart;
    ! ARC ON
    MoveL W3_0002,vWeld,fine,tTorch\WObj:=wpPart;
    ! ARC OFF
    MoveL W3_retr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W3_up01,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC

  PROC weld_W4()
    ConfJ\Off;
    ConfL\Off;
    MoveL W4_to01,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_to02,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_to03,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_appr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_0001,vAir,fine,tTorch\WObj:=wpPart;
    ! ARC ON
    MoveL W4_0002,vWeld,fine,tTorch\WObj:=wpPart;
    ! ARC OFF
    MoveL W4_retr,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_up01,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_up02,vAir,fine,tTorch\WObj:=wpPart;
    MoveL W4_up03,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC
  PROC run_WPCAL()
    ConfJ\Off;
    ConfL\Off;
    MoveJ wpSafe,v100,fine,tTorch\WObj:=wpPart;
    weld_W1;
    weld_W2;
    weld_W3;
    weld_W4;
    ConfJ\Off;
    ConfL\Off;
    MoveL wpSafe,vAir,fine,tTorch\WObj:=wpPart;
    ConfJ\On;
    ConfL\On;
  ENDPROC
ENDMODULE
