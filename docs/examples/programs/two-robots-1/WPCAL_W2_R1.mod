MODULE WPCAL_W2_R1
  ! robot 1 (YASKAWA MOTOMAN MH6) of two, task T_ROB1
  ! written by wpcal 0.1.1 from plan.json: coordinated motion, the part in
  !   the hand of robot 2
  ! seam W2: z7 fillet weld, process 135, PA, 325 A, 33 V, 9.7 m/min wire,
  !   7.1 mm/s, tee fillet, 150.0 mm, 1 line
  ! 7.1 mm/s along the seam, 21.1 s; joint S of robot 2 at s = 120.0 mm
  !   allows 6269.1 mm/s
  ! in the part the wire is at most 0.000 mm and 0.00 deg off the seam
  !   (allowed: 0.05 mm, 0.5 deg)
  ! the part is at most 0.11 deg and 1.4 mm from where the plan has it
  ! checked: this text, executed and swept: both arms, torch and wire, the
  !   held part and the bodies of the cell; its moves as planned: free; 321
  !   states checked; least: robot 1 nozzle to robot 2 base plate, 7.4 mm (3
  !   mm asked) at s = 149.5 mm
  ! weld speed <= 7.1 mm/s
  ! air speed <= 50 mm/s
  ! the arc burns from SEAM START to SEAM END: RUN IT with the arc blocked
  !   at the controller FIRST
  ! NOT CHECKED: cables, hoses, what the cell does not have, the way to the
  !   first point. RUN IT DRY FIRST
  ! targets are in the part, which ROB_2 holds; mm; q1..q4 = w,x,y,z;
  !   confdata from the joints
  ! the tool must be declared on the controller; its z is the wire
  ! ID is the number of the mark, the same in both modules: load and start
  !   both tasks together
  PERS tasks tasks_W2{2}:=[["T_ROB1"],["T_ROB2"]];
  VAR syncident start_W2;
  VAR syncident end_W2;
  LOCAL CONST speeddata vFirst:=[50,20,50,20];
  PERS wobjdata part_W2:=[FALSE,FALSE,"ROB_2",[[0,0,0],[1,0,0,0]],[[-100.00000,-60.00000,220.00000],[0.707106781,-0.707106781,0.000000000,0.000000000]]];
  LOCAL CONST speeddata vWeld:=[7.1,500,7.1,500];
  LOCAL CONST speeddata vAir:=[50,500,50,500];
  LOCAL PERS seamdata sm_W2:=[0,0.5,[0,0,0,0,0,0,0,0,0],0.2,0,0,0,0,[0,0,0,0,0,0,0,0,0],0,0.7,[0,0,0,0,0,0,0,0,0],0,0,[0,0,0,0,0,0,0,0,0],0.5];
  LOCAL PERS welddata wd_W2:=[7.1,0,[3,0,33,161.7,0,325,0,0,0],[0,0,0,0,0,0,0,0,0]];
  LOCAL CONST jointtarget W2_start:=[[71.84141,-27.54352,39.72627,-45.75835,85.88630,-90.62428],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_0001:=[[25.00000,56.00000,10.00000],[0.264174227,-0.637693874,0.668480628,0.276933478],[0,-1,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_0002:=[[175.00000,56.00000,10.00000],[0.264178819,-0.637691971,0.668482201,0.276929682],[0,-1,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST robtarget W2_retr:=[[174.99970,20.64127,45.35195],[0.264178819,-0.637691971,0.668482201,0.276929682],[0,-1,-1,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];

  PROC weld_W2()
    MoveAbsJ W2_start,vFirst,fine,tTorch;
    SyncMoveOn start_W2,tasks_W2;
    ! SEAM START
    ArcLStart W2_0001\ID:=10,vAir,sm_W2,wd_W2,fine,tTorch\WObj:=part_W2;
    ArcLEnd W2_0002\ID:=20,vWeld,sm_W2,wd_W2,fine,tTorch\WObj:=part_W2;
    ! SEAM END
    MoveL W2_retr\ID:=30,vAir,fine,tTorch\WObj:=part_W2;
    SyncMoveOff end_W2;
  ENDPROC
ENDMODULE
