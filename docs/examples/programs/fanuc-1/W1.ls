/PROG  W1
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 13;
PROTECT = READ_WRITE;
TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,
      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;
DEFAULT_GROUP = 1,*,*,*,*;
CONTROL_CODE = 00000000 00000000;
/MN
   1:  !W1 ;
   2:  !tee fillet, 8.0 mm, 1 line, 95 % ;
   3:  !  error up to 0.227 mm ;
   4:  UFRAME_NUM=4 ;
   5:  UTOOL_NUM=2 ;
   6:L P[1] 100mm/sec FINE ;
   7:L P[2] 100mm/sec FINE ;
   8:L P[3] 100mm/sec FINE ;
   9:  !ARC ON ;
  10:L P[4] 8mm/sec FINE ;
  11:  !ARC OFF ;
  12:L P[5] 100mm/sec FINE ;
  13:L P[6] 100mm/sec FINE ;
/POS
P[1]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    -6.386  mm,	Y =    58.145  mm,	Z =   157.576  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[2]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   -10.355  mm,	Y =    56.000  mm,	Z =    45.356  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[3]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    25.001  mm,	Y =    56.000  mm,	Z =    10.000  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[4]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    25.001  mm,	Y =    64.000  mm,	Z =    10.000  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[5]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   -10.354  mm,	Y =    64.000  mm,	Z =    45.356  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
P[6]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    -6.391  mm,	Y =    66.142  mm,	Z =   157.423  mm,
	W =   135.000 deg,	P =     0.000 deg,	R =    90.000 deg
};
/END
