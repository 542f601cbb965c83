/PROG  WPCAL_TOUCH
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 134;
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
   6:  !the tool centre point is the tip ;
   7:  !  of the wire ;
   8:  !SAFETY: contact turns DI[1] on. ;
   9:  !  Before the first run hold the ;
  10:  !  wire against the part by hand ;
  11:  !  and see it turn on: without it ;
  12:  !  the torch drives 16 mm on, ;
  13:  !  into the part ;
  14:  !SAFETY: during searches the ;
  15:  !  sensing voltage is on the ;
  16:  !  wire: keep away from wire and ;
  17:  !  torch ;
  18:  !SAFETY: after a missed search ;
  19:  !  the part may be elsewhere. The ;
  20:  !  program stops and names the ;
  21:  !  search: look at the part ;
  22:  !  before you start it again. It ;
  23:  !  then goes on with the next ;
  24:  !  search, after 2 misses it ends ;
  25:  !the way to the start of a search ;
  26:  !  is sensed as well, at 30 mm/s ;
  27:  !NOT CHECKED: the arm, fixtures, ;
  28:  !  cables, the way to the first ;
  29:  !  point. RUN IT DRY FIRST ;
  30:  !run it dry: without the part, ;
  31:  !  every search is missed ;
  32:  !  (most_misses). Searches 10 ;
  33:  !  mm/s, air 100 mm/s ;
  34:  !results: R[156] to R[157] ;
  35:  !  outcomes, PR[52] to PR[53] ;
  36:  !  places, in the order of the ;
  37:  !  searches: copy posreg.va and ;
  38:  !  numreg.va ;
  39:  !R[151] to R[155]: fingerprint, ;
  40:  !  user frame, tool, count ;
  41:  !UFRAME 8 becomes the part as ;
  42:  !  planned (PR[51]): weld ;
  43:  !  programs must use another one ;
  44:  !points and places are relative ;
  45:  !  to it, mm, R = Rz(R) Ry(P) ;
  46:  !  Rx(W), deg ;
  47:  !CONFIG as given by the user ;
  48:  !search: what it touches, stroke ;
  49:  !  and direction in the part ;
  50:  !  T1: plane, end of the wire, ;
  51:  !  16.0 mm along (0.00 0.00 ;
  52:  !  -1.00) ;
  53:  !  T4: plane, side of the wire, ;
  54:  !  16.0 mm along (0.00 1.00 0.00) ;
  55:  UTOOL_NUM=1 ;
  56:  PR[51]=LPOS ;
  57:  PR[51,1]=812.000 ;
  58:  PR[51,2]=(-240.000) ;
  59:  PR[51,3]=156.000 ;
  60:  PR[51,4]=1.146 ;
  61:  PR[51,5]=(-2.005) ;
  62:  PR[51,6]=34.377 ;
  63:  UFRAME[8]=PR[51] ;
  64:  UFRAME_NUM=8 ;
  65:  R[151]=2705 ;
  66:  R[152]=21440 ;
  67:  R[153]=8 ;
  68:  R[154]=1 ;
  69:  R[155]=2 ;
  70:  R[156]=0 ;
  71:  R[157]=0 ;
  72:  R[158]=0 ;
  73:  !T1 ;
  74:J P[1] 10% FINE ;
  75:  IF DI[1]=ON,JMP LBL[3] ;
  76:  SKIP CONDITION DI[1]=ON ;
  77:L P[2] 30mm/sec FINE Skip,LBL[1] ;
  78:  JMP LBL[3] ;
  79:  LBL[1] ;
  80:L P[3] 10mm/sec FINE Skip,LBL[2],PR[52]=LPOS ;
  81:  WAIT 0.10(sec) ;
  82:  R[156]=1 ;
  83:  JMP LBL[4] ;
  84:  LBL[2] ;
  85:  R[156]=2 ;
  86:  MESSAGE[T1 missed] ;
  87:  JMP LBL[4] ;
  88:  LBL[3] ;
  89:  R[156]=3 ;
  90:  MESSAGE[T1 signal on] ;
  91:L P[1] 100mm/sec FINE ;
  92:  LBL[4] ;
  93:  IF R[156]=3,JMP LBL[5] ;
  94:L P[2] 100mm/sec FINE ;
  95:L P[4] 100mm/sec FINE ;
  96:  LBL[5] ;
  97:  IF R[156]=1,JMP LBL[6] ;
  98:  R[158]=R[158]+1 ;
  99:  IF R[158]>=2,JMP LBL[13] ;
 100:  PAUSE ;
 101:  LBL[6] ;
 102:  !T4 ;
 103:L P[5] 100mm/sec FINE ;
 104:  IF DI[1]=ON,JMP LBL[9] ;
 105:  SKIP CONDITION DI[1]=ON ;
 106:L P[6] 30mm/sec FINE Skip,LBL[7] ;
 107:  JMP LBL[9] ;
 108:  LBL[7] ;
 109:L P[7] 10mm/sec FINE Skip,LBL[8],PR[53]=LPOS ;
 110:  WAIT 0.10(sec) ;
 111:  R[157]=1 ;
 112:  JMP LBL[10] ;
 113:  LBL[8] ;
 114:  R[157]=2 ;
 115:  MESSAGE[T4 missed] ;
 116:  JMP LBL[10] ;
 117:  LBL[9] ;
 118:  R[157]=3 ;
 119:  MESSAGE[T4 signal on] ;
 120:L P[5] 100mm/sec FINE ;
 121:  LBL[10] ;
 122:  IF R[157]=3,JMP LBL[11] ;
 123:L P[6] 100mm/sec FINE ;
 124:L P[8] 100mm/sec FINE ;
 125:  LBL[11] ;
 126:  IF R[157]=1,JMP LBL[12] ;
 127:  R[158]=R[158]+1 ;
 128:  IF R[158]>=2,JMP LBL[13] ;
 129:  PAUSE ;
 130:  LBL[12] ;
 131:  END ;
 132:  LBL[13] ;
 133:  MESSAGE[2 misses: program ends] ;
 134:  ABORT ;
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
