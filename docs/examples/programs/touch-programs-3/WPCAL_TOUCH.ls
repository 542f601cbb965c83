/PROG  WPCAL_TOUCH
/ATTR
OWNER = MNEDITOR;
COMMENT = "wpcal";
LINE_COUNT = 132;
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
  22:  !  search, after 2 misses it ends ;
  23:  !the way to the start of a search ;
  24:  !  is sensed as well, at 30 mm/s ;
  25:  !NOT CHECKED: the arm, fixtures, ;
  26:  !  cables, the way to the first ;
  27:  !  point. RUN IT DRY FIRST ;
  28:  !run it dry: without the part, ;
  29:  !  every search is missed ;
  30:  !  (most_misses). Searches 10 ;
  31:  !  mm/s, air 100 mm/s ;
  32:  !results: R[156] to R[157] ;
  33:  !  outcomes, PR[52] to PR[53] ;
  34:  !  places, in the order of the ;
  35:  !  searches: copy posreg.va and ;
  36:  !  numreg.va ;
  37:  !R[151] to R[155]: fingerprint, ;
  38:  !  user frame, tool, count ;
  39:  !UFRAME 8 becomes the part as ;
  40:  !  planned (PR[51]): weld ;
  41:  !  programs must use another one ;
  42:  !points and places are relative ;
  43:  !  to it, mm, R = Rz(R) Ry(P) ;
  44:  !  Rx(W), deg ;
  45:  !CONFIG as given by the user ;
  46:  !search: what it touches, stroke ;
  47:  !  and direction in the part ;
  48:  !  T1: plane, end of the wire, ;
  49:  !  16.0 mm along (0.00 0.00 ;
  50:  !  -1.00) ;
  51:  !  T4: plane, side of the wire, ;
  52:  !  16.0 mm along (0.00 1.00 0.00) ;
  53:  UTOOL_NUM=1 ;
  54:  PR[51]=LPOS ;
  55:  PR[51,1]=812.000 ;
  56:  PR[51,2]=(-240.000) ;
  57:  PR[51,3]=156.000 ;
  58:  PR[51,4]=1.146 ;
  59:  PR[51,5]=(-2.005) ;
  60:  PR[51,6]=34.377 ;
  61:  UFRAME[8]=PR[51] ;
  62:  UFRAME_NUM=8 ;
  63:  R[151]=2705 ;
  64:  R[152]=21440 ;
  65:  R[153]=8 ;
  66:  R[154]=1 ;
  67:  R[155]=2 ;
  68:  R[156]=0 ;
  69:  R[157]=0 ;
  70:  R[158]=0 ;
  71:  !T1 ;
  72:J P[1] 10% FINE ;
  73:  IF DI[1]=ON,JMP LBL[3] ;
  74:  SKIP CONDITION DI[1]=ON ;
  75:L P[2] 30mm/sec FINE Skip,LBL[1] ;
  76:  JMP LBL[3] ;
  77:  LBL[1] ;
  78:L P[3] 10mm/sec FINE Skip,LBL[2],PR[52]=LPOS ;
  79:  WAIT 0.10(sec) ;
  80:  R[156]=1 ;
  81:  JMP LBL[4] ;
  82:  LBL[2] ;
  83:  R[156]=2 ;
  84:  MESSAGE[T1 missed] ;
  85:  JMP LBL[4] ;
  86:  LBL[3] ;
  87:  R[156]=3 ;
  88:  MESSAGE[T1 signal on] ;
  89:L P[1] 100mm/sec FINE ;
  90:  LBL[4] ;
  91:  IF R[156]=3,JMP LBL[5] ;
  92:L P[2] 100mm/sec FINE ;
  93:L P[4] 100mm/sec FINE ;
  94:  LBL[5] ;
  95:  IF R[156]=1,JMP LBL[6] ;
  96:  R[158]=R[158]+1 ;
  97:  IF R[158]>=2,JMP LBL[13] ;
  98:  PAUSE ;
  99:  LBL[6] ;
 100:  !T4 ;
 101:L P[5] 100mm/sec FINE ;
 102:  IF DI[1]=ON,JMP LBL[9] ;
 103:  SKIP CONDITION DI[1]=ON ;
 104:L P[6] 30mm/sec FINE Skip,LBL[7] ;
 105:  JMP LBL[9] ;
 106:  LBL[7] ;
 107:L P[7] 10mm/sec FINE Skip,LBL[8],PR[53]=LPOS ;
 108:  WAIT 0.10(sec) ;
 109:  R[157]=1 ;
 110:  JMP LBL[10] ;
 111:  LBL[8] ;
 112:  R[157]=2 ;
 113:  MESSAGE[T4 missed] ;
 114:  JMP LBL[10] ;
 115:  LBL[9] ;
 116:  R[157]=3 ;
 117:  MESSAGE[T4 signal on] ;
 118:L P[5] 100mm/sec FINE ;
 119:  LBL[10] ;
 120:  IF R[157]=3,JMP LBL[11] ;
 121:L P[6] 100mm/sec FINE ;
 122:L P[8] 100mm/sec FINE ;
 123:  LBL[11] ;
 124:  IF R[157]=1,JMP LBL[12] ;
 125:  R[158]=R[158]+1 ;
 126:  IF R[158]>=2,JMP LBL[13] ;
 127:  PAUSE ;
 128:  LBL[12] ;
 129:  END ;
 130:  LBL[13] ;
 131:  MESSAGE[2 misses: program ends] ;
 132:  ABORT ;
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
