/PROG  WPCAL_TOUCH
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 110;
PROTECT = READ_WRITE;
TCD:  STACK_SIZE = 0, TASK_PRIORITY = 50, TIME_SLICE = 0,
      BUSY_LAMP_OFF = 0, ABORT_REQUEST = 0, PAUSE_REQUEST = 0;
DEFAULT_GROUP = 1,*,*,*,*;
CONTROL_CODE = 00000000 00000000;
/MN
   1:  !written by wpcal 0.1.1 from the ;
   2:  !  plan in touches.json, ;
   3:  !  fingerprint 0a9153c0 ;
   4:  !part tee.step: 2 searches, wire ;
   5:  !  1.2 mm, stick-out 15 mm ;
   6:  !SAFETY: contact turns DI[1] on. ;
   7:  !  Before the first run hold the ;
   8:  !  wire against the part by hand ;
   9:  !  and see it turn on: without it ;
  10:  !  the torch drives 16 mm on, ;
  11:  !  into the part ;
  12:  !SAFETY: during searches the ;
  13:  !  sensing voltage is on the ;
  14:  !  wire: keep away from wire and ;
  15:  !  torch ;
  16:  !SAFETY: after a missed search ;
  17:  !  the part may be elsewhere. The ;
  18:  !  program stops and names the ;
  19:  !  search: look at the part ;
  20:  !  before you start it again. It ;
  21:  !  then goes on with the next ;
  22:  !  search ;
  23:  !NOT CHECKED: the arm, fixtures, ;
  24:  !  cables, the way to the first ;
  25:  !  point. RUN IT DRY FIRST ;
  26:  !run it dry: without the part, ;
  27:  !  every search is missed. ;
  28:  !  Searches 10 mm/s, air 100 mm/s ;
  29:  !results: R[156] to R[157] ;
  30:  !  outcomes, PR[52] to PR[53] ;
  31:  !  places, in the order of the ;
  32:  !  searches: copy posreg.va and ;
  33:  !  numreg.va ;
  34:  !R[151] to R[155]: fingerprint, ;
  35:  !  user frame, tool, count ;
  36:  !UFRAME 8 becomes the part as ;
  37:  !  planned (PR[51]): weld ;
  38:  !  programs must use another one ;
  39:  !points and places are relative ;
  40:  !  to it, mm, R = Rz(R) Ry(P) ;
  41:  !  Rx(W), deg ;
  42:  !CONFIG as given by the user ;
  43:  !search: what it touches, stroke ;
  44:  !  and direction in the part ;
  45:  !  T1: plane, end of the wire, ;
  46:  !  16.0 mm along (0.00 0.00 ;
  47:  !  -1.00) ;
  48:  !  T4: plane, side of the wire, ;
  49:  !  16.0 mm along (0.00 1.00 0.00) ;
  50:  UTOOL_NUM=1 ;
  51:  PR[51]=LPOS ;
  52:  PR[51,1]=812.000 ;
  53:  PR[51,2]=(-240.000) ;
  54:  PR[51,3]=156.000 ;
  55:  PR[51,4]=1.146 ;
  56:  PR[51,5]=(-2.005) ;
  57:  PR[51,6]=34.377 ;
  58:  UFRAME[8]=PR[51] ;
  59:  UFRAME_NUM=8 ;
  60:  R[151]=2705 ;
  61:  R[152]=21440 ;
  62:  R[153]=8 ;
  63:  R[154]=1 ;
  64:  R[155]=2 ;
  65:  R[156]=0 ;
  66:  R[157]=0 ;
  67:  !T1 ;
  68:J P[1] 10% FINE ;
  69:L P[2] 100mm/sec FINE ;
  70:  IF DI[1]=ON,JMP LBL[2] ;
  71:  SKIP CONDITION DI[1]=ON ;
  72:L P[3] 10mm/sec FINE Skip,LBL[1],PR[52]=LPOS ;
  73:  WAIT 0.10(sec) ;
  74:  R[156]=1 ;
  75:  JMP LBL[3] ;
  76:  LBL[1] ;
  77:  R[156]=2 ;
  78:  MESSAGE[T1 missed] ;
  79:  JMP LBL[3] ;
  80:  LBL[2] ;
  81:  R[156]=3 ;
  82:  MESSAGE[T1 signal on] ;
  83:  LBL[3] ;
  84:L P[2] 100mm/sec FINE ;
  85:L P[4] 100mm/sec FINE ;
  86:  IF R[156]=1,JMP LBL[4] ;
  87:  PAUSE ;
  88:  LBL[4] ;
  89:  !T4 ;
  90:L P[5] 100mm/sec FINE ;
  91:L P[6] 100mm/sec FINE ;
  92:  IF DI[1]=ON,JMP LBL[6] ;
  93:  SKIP CONDITION DI[1]=ON ;
  94:L P[7] 10mm/sec FINE Skip,LBL[5],PR[53]=LPOS ;
  95:  WAIT 0.10(sec) ;
  96:  R[157]=1 ;
  97:  JMP LBL[7] ;
  98:  LBL[5] ;
  99:  R[157]=2 ;
 100:  MESSAGE[T4 missed] ;
 101:  JMP LBL[7] ;
 102:  LBL[6] ;
 103:  R[157]=3 ;
 104:  MESSAGE[T4 signal on] ;
 105:  LBL[7] ;
 106:L P[6] 100mm/sec FINE ;
 107:L P[8] 100mm/sec FINE ;
 108:  IF R[157]=1,JMP LBL[8] ;
 109:  PAUSE ;
 110:  LBL[8] ;
/POS
P[1]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    39.998  mm,	Y =   100.000  mm,	Z =   115.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[2]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    39.999  mm,	Y =   100.000  mm,	Z =    18.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[3]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    39.999  mm,	Y =   100.000  mm,	Z =     2.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[4]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    39.998  mm,	Y =   100.000  mm,	Z =   115.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[5]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    39.999  mm,	Y =    -8.600  mm,	Z =   115.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[6]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    40.000  mm,	Y =    -8.600  mm,	Z =     5.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[7]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    40.000  mm,	Y =     7.400  mm,	Z =     5.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
P[8]{
   GP1:
	UF : 8, UT : 1,		CONFIG : 'N U T, 0, 0, 0',
	X =    39.999  mm,	Y =    -8.600  mm,	Z =   115.000  mm,
	W =   180.000 deg,	P =     0.000 deg,	R =     0.000 deg
};
/END
