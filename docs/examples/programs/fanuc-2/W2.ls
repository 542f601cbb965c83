/PROG  W2
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 18;
PROTECT = READ_WRITE;
TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,
      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;
DEFAULT_GROUP = 1,*,*,*,*;
CONTROL_CODE = 00000000 00000000;
/MN
   1:  !W2 ;
   2:  !z6.5 fillet weld, process 135, ;
   3:  !  PB, 290 A, 30.5 V, 7.4 m/min ;
   4:  !  wire, 6.3 mm/s, tee fillet, ;
   5:  !  150.0 mm, 1 line, 95 % error ;
   6:  !  up to 0.265 mm ;
   7:  UFRAME_NUM=4 ;
   8:  UTOOL_NUM=2 ;
   9:L P[1] 100mm/sec FINE ;
  10:L P[2] 100mm/sec FINE ;
  11:L P[3] 100mm/sec FINE ;
  12:  !SEAM START ;
  13:  Weld Start[1,3] ;
  14:L P[4] 38cm/min FINE ;
  15:  Weld End[1,3] ;
  16:  !SEAM END ;
  17:L P[5] 100mm/sec FINE ;
  18:L P[6] 100mm/sec FINE ;
/POS
P[1]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    28.949  mm,	Y =    22.778  mm,	Z =   157.002  mm,
	W =  -135.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    25.001  mm,	Y =    20.644  mm,	Z =    45.355  mm,
	W =  -135.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[3]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =    25.001  mm,	Y =    56.000  mm,	Z =    10.000  mm,
	W =  -135.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[4]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   175.001  mm,	Y =    55.999  mm,	Z =    10.000  mm,
	W =  -135.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[5]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   175.001  mm,	Y =    20.643  mm,	Z =    45.355  mm,
	W =  -135.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[6]{
   GP1:
	UF : 4, UT : 2,		CONFIG : 'N U T, 0, 0, 0',
	X =   178.762  mm,	Y =    22.676  mm,	Z =   151.706  mm,
	W =  -135.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
