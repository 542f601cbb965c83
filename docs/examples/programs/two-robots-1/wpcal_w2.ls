/PROG  WPCAL_W2
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 59;
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
  27:  !weld speed <= 7.1 mm/s ;
  28:  !air speed <= 50 mm/s ;
  29:  !the arc burns from SEAM START to ;
  30:  !  SEAM END: RUN IT with the arc ;
  31:  !  blocked at the controller ;
  32:  !  FIRST ;
  33:  !NOT CHECKED: cables, hoses, what ;
  34:  !  the cell does not have, the ;
  35:  !  way to the first point. RUN IT ;
  36:  !  DRY FIRST ;
  37:  !group 1: torch, follower, group ;
  38:  !  2: part, leader, positions in ;
  39:  !  the base of each robot ;
  40:  !set UTOOL 1 of group 2 to the ;
  41:  !  part on the flange: ;
  42:  ! X -100.000 ;
  43:  ! Y -60.000 ;
  44:  ! Z 220.000 ;
  45:  ! W -90.000 ;
  46:  ! P 0.000 ;
  47:  ! R 0.000 ;
  48:  UFRAME_NUM[GP1]=0 ;
  49:  UFRAME_NUM[GP2]=0 ;
  50:  UTOOL_NUM[GP1]=1 ;
  51:  UTOOL_NUM[GP2]=1 ;
  52:J P[1] 10% FINE ;
  53:L P[2] 50mm/sec FINE COORD ;
  54:  !SEAM START ;
  55:  Weld Start[1,3] ;
  56:L P[3] 7mm/sec FINE COORD ;
  57:  Weld End[1,3] ;
  58:  !SEAM END ;
  59:L P[4] 50mm/sec FINE COORD ;
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
