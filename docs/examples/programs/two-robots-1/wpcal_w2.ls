/PROG  WPCAL_W2
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 57;
PROTECT = READ_WRITE;
TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,
      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;
DEFAULT_GROUP = 1,1,*,*,*;
CONTROL_CODE = 00000000 00000000;
/MN
   1:  !written by wpcal 0.1.1 from ;
   2:  !  plan.json: coordinated motion, ;
   3:  !  the part in the hand of robot ;
   4:  !  2 ;
   5:  !seam W2: z7 fillet weld, process ;
   6:  !  135, PA, 325 A, 33 V, 9.7 ;
   7:  !  m/min wire, 7.1 mm/s, tee ;
   8:  !  fillet, 150.0 mm, 1 line ;
   9:  !7.1 mm/s along the seam, 21.1 s, ;
  10:  !  joint S of robot 2 at s = ;
  11:  !  120.0 mm allows 6269.1 mm/s ;
  12:  !in the part the wire is at most ;
  13:  !  0.000 mm and 0.00 deg off the ;
  14:  !  seam (allowed: 0.05 mm, 0.5 ;
  15:  !  deg) ;
  16:  !the part is at most 0.12 deg and ;
  17:  !  2.8 mm from where the plan has ;
  18:  !  it ;
  19:  !checked: this text, executed and ;
  20:  !  swept: both arms, torch and ;
  21:  !  wire, the held part and the ;
  22:  !  bodies of the cell, its moves ;
  23:  !  as planned: free, 321 states ;
  24:  !  checked, least: robot 1 nozzle ;
  25:  !  to robot 2 base plate, 7.4 mm ;
  26:  !  (3 mm asked) at s = 149.5 mm ;
  27:  !the arc burns from SEAM START to ;
  28:  !  SEAM END: RUN IT with the arc ;
  29:  !  blocked at the controller ;
  30:  !  FIRST ;
  31:  !NOT CHECKED: cables, hoses, what ;
  32:  !  the cell does not have, the ;
  33:  !  way to the first point. RUN IT ;
  34:  !  DRY FIRST ;
  35:  !group 1: torch, follower, group ;
  36:  !  2: part, leader, positions in ;
  37:  !  the base of each robot ;
  38:  !set UTOOL 1 of group 2 to the ;
  39:  !  part on the flange: ;
  40:  ! X -100.000 ;
  41:  ! Y -60.000 ;
  42:  ! Z 220.000 ;
  43:  ! W -90.000 ;
  44:  ! P 0.000 ;
  45:  ! R 0.000 ;
  46:  UFRAME_NUM[GP1]=0 ;
  47:  UFRAME_NUM[GP2]=0 ;
  48:  UTOOL_NUM[GP1]=1 ;
  49:  UTOOL_NUM[GP2]=1 ;
  50:J P[1] 10% FINE ;
  51:L P[2] 50mm/sec FINE COORD ;
  52:  !SEAM START ;
  53:  Weld Start[1,3] ;
  54:L P[3] 7mm/sec FINE COORD ;
  55:  Weld End[1,3] ;
  56:  !SEAM END ;
  57:L P[4] 50mm/sec FINE COORD ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, 0',
	X =   384.920  mm,	Y =   378.210  mm,	Z =   662.547  mm,
	W =  -170.260 deg,	P =     0.126 deg,	R =   165.294 deg
   GP2:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1156.314  mm,	Y =  -409.182  mm,	Z =   641.372  mm,
	W =   -45.341 deg,	P =    -9.736 deg,	R =    78.013 deg
};
P[2]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, 0',
	X =   382.878  mm,	Y =   370.000  mm,	Z =   613.268  mm,
	W =  -170.260 deg,	P =     0.126 deg,	R =   165.294 deg
   GP2:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1156.314  mm,	Y =  -409.182  mm,	Z =   641.372  mm,
	W =   -45.341 deg,	P =    -9.736 deg,	R =    78.013 deg
};
P[3]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, 0',
	X =   379.999  mm,	Y =   337.043  mm,	Z =   622.034  mm,
	W =  -169.801 deg,	P =     0.772 deg,	R =   158.066 deg
   GP2:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1105.296  mm,	Y =  -520.467  mm,	Z =   622.750  mm,
	W =   -44.707 deg,	P =   -10.223 deg,	R =    70.671 deg
};
P[4]{
   GP1:
	UF : 0, UT : 1,		CONFIG : 'F U T, 0, 0, 0',
	X =   382.690  mm,	Y =   345.504  mm,	Z =   671.239  mm,
	W =  -169.801 deg,	P =     0.772 deg,	R =   158.066 deg
   GP2:
	UF : 0, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =  1105.296  mm,	Y =  -520.467  mm,	Z =   622.750  mm,
	W =   -44.707 deg,	P =   -10.223 deg,	R =    70.671 deg
};
/END
