MODULE WPCAL_W2_R2
  ! robot 2 (YASKAWA MOTOMAN MH6) of two, task T_ROB2
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
  ! targets are joints in deg; tool0 is the flange, with the load that is
  !   active
  ! the part is in the hand; its place on the flange is the object frame of
  !   robot 1's work object
  ! ID is the number of the mark, the same in both modules: load and start
  !   both tasks together
  PERS tasks tasks_W2{2}:=[["T_ROB1"],["T_ROB2"]];
  VAR syncident start_W2;
  VAR syncident end_W2;
  LOCAL CONST speeddata vFirst:=[50,20,50,20];
  LOCAL CONST speeddata vHeld:=[50,500,50,500];
  LOCAL CONST jointtarget W2_held_0000:=[[-13.83923,34.54873,25.44450,5.78569,-104.70356,-80.33603],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST jointtarget W2_held_0001:=[[-13.83923,34.54873,25.44450,5.78569,-104.70356,-80.33603],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST jointtarget W2_held_0002:=[[-19.03407,35.35493,25.87341,7.65892,-105.37177,-80.86173],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];
  LOCAL CONST jointtarget W2_held_0003:=[[-19.03407,35.35493,25.87341,7.65892,-105.37177,-80.86173],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];

  PROC weld_W2()
    MoveAbsJ W2_held_0000,vFirst,fine,tool0;
    SyncMoveOn start_W2,tasks_W2;
    ArcMoveAbsJ W2_held_0001\ID:=10,vHeld,fine,tool0;
    ArcMoveAbsJ W2_held_0002\ID:=20,vHeld,fine,tool0;
    ArcMoveAbsJ W2_held_0003\ID:=30,vHeld,fine,tool0;
    SyncMoveOff end_W2;
  ENDPROC
ENDMODULE
